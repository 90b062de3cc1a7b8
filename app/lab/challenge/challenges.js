/** The challenges of the lab's page: what its address opens, and the ways from them to the lab.
 * @typedef {import("../view/experiment.js").Offered & {hulls: Record<string, number[][]>}} Offered */
import {make} from "../lessons/dom.js";
import {beginning, toAddress} from "../view/address.js";
import {addressOf, isPublic, Maker} from "./maker.js";
import {asksForChallenge, SERVO, TRANSFER} from "./rules.js";
import {Screen} from "./screen.js";

export class Challenges {
  /** @param {Offered} offered */
  constructor({presets, scenes, hulls}) {
    const scene = scenes[presets[0].scene], usual = beginning(presets[0], scene), title = document.title;
    this.box = make("main", {class: "challenge", hidden: true});
    document.querySelector("main")?.after(this.box);
    this.title = title;
    this.maker = new Maker(scene, challenge => this.screen.played.add(challenge, 0)); // their own game is practice
    this.screen = new Screen(this.box, {scene, hulls}, {
      address: challenge => isPublic() ? addressOf(challenge) : "",
      friend: challenge => this.maker.open(challenge, challenge.level),
      robot: ({demonstrator, start}, steps) => {
        location.hash = toAddress({...usual, demonstrator, start, steps, transfer: TRANSFER, servo: SERVO}, presets[0], scene);
      },
    });
  }

  /** Show the challenge that the page's address asks for. @returns {boolean} whether it asks for one */
  route() {
    const isAsked = asksForChallenge(location.hash);
    this.box.hidden = !isAsked;
    document.body.classList.toggle("in-challenge", isAsked);
    document.title = isAsked ? "viewimit challenge" : this.title;
    if (isAsked) this.screen.open(location.hash);
    return isAsked;
  }
}
