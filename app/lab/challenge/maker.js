/** "Challenge a friend": what makes a challenge of a pose, and gives its link.
 * @import {Challenge, Level} from "./rules.js" @import {Scene} from "../engine/world.js" */
import {World} from "../engine/engine.js";
import {button, make} from "../lessons/dom.js";
import {copy} from "../view/page.js";
import {say} from "../view/svg.js";
import {stepsText} from "../view/words.js";
import {fromPose, LEVELS, POINTS, robotSteps, toLink} from "./rules.js";

/** The levels, side by side. @param {(level: Level) => void} choose */
export function levelButtons(choose) {
  const levels = /** @type {Level[]} */ (Object.keys(LEVELS));
  const buttons = levels.map(level => make("button", {type: "button", onclick: () => choose(level)}, LEVELS[level].title));
  return {
    element: make("div", {class: "levels", role: "group", "aria-label": "Level"}, ...buttons),
    /** @param {Level} chosen @param {boolean} isFixed whether no other can be chosen */
    show: (chosen, isFixed) => buttons.forEach((button, k) => {
      button.setAttribute("aria-pressed", String(levels[k] === chosen));
      button.disabled = isFixed && levels[k] !== chosen;
    }),
  };
}

/** Where a link opens for others: an address of the web, and not a file's or this device's own. */
export const isPublic = () => location.protocol.startsWith("http") && !/^(localhost|127\.|\[::1\])/.test(location.hostname);

/** @param {Challenge} challenge */
export const addressOf = challenge => location.href.split("#")[0] + toLink(challenge);

export class Maker {
  /** @param {Scene} scene @param {(challenge: Challenge) => void} tried whoever made it looks at it */
  constructor(scene, tried) {
    this.world = new World(scene, POINTS);
    /** @type {Pick<Challenge, "demonstrator" | "start">} */
    this.pose = {demonstrator: [], start: []};
    /** @type {Level} */
    this.level = "points";
    this.made = /** @type {Challenge | null} */ (null);
    this.name = make("input", {type: "text", maxlength: 20, autocomplete: "nickname", oninput: () => this.#show()});
    this.levels = levelButtons(level => {
      this.level = level;
      this.#show();
    });
    this.says = make("p", {class: "says", role: "status"});
    this.link = make("input", {type: "text", readonly: true, "aria-label": "The link"});
    this.copying = button("Copy link", () => void copy(this.copying, this.link.value, "The link:"), "filled");
    this.playing = make("a", {class: "button"}, "Look at it");
    this.playing.addEventListener("click", () => {
      if (this.made) tried(this.made);
      this.dialog.close();
    });
    const hint = isPublic() ? null : make("p", {class: "hint"}, location.protocol === "file:"
      ? "This page is a file: send it too, and add the link’s end to its address." : "This link opens on this device only.");
    this.sending = make("div", {class: "sending"}, this.link, this.copying, this.playing, hint);
    this.dialog = document.body.appendChild(make("dialog", {class: "maker", closedby: "any", "aria-label": "Challenge a friend"},
      make("form", {method: "dialog"}, make("button", {class: "close", "aria-label": "Close"}, "×")),
      make("h2", {}, "Challenge a friend"),
      make("p", {}, "A friend copies the orange arm’s pose. The fewer steps, the better."),
      make("label", {}, "Your name ", this.name), this.levels.element,
      this.says, this.sending, make("p", {}, "Or play ",
        make("a", {href: "#challenge=today", onclick: () => this.dialog.close()}, "the pose of today"), " yourself.")));
  }

  /** @param {Pick<Challenge, "demonstrator" | "start">} pose rad @param {Level} [level] */
  open(pose, level = this.level) {
    this.pose = pose;
    this.level = level;
    this.#show();
    this.dialog.showModal();
  }

  #show() {
    const {world, level, name} = this, made = fromPose(world, {...this.pose, level, by: name.value});
    this.levels.show(level, false);
    this.sending.hidden = typeof made === "string";
    if (typeof made === "string") return say(this.says, made);
    this.made = made;
    say(this.says, `${LEVELS[level].says} The robot needs ${stepsText(robotSteps(world, made) ?? 0)}.`);
    this.link.value = isPublic() ? addressOf(made) : toLink(made);
    this.playing.href = toLink(made);
  }
}
