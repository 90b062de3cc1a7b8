/** What the engine answers to a test's questions: Python asks, and compares the answers with the library's. */

const numbers = value => Array.from(value, v => Number.isFinite(v) ? v : null);

export function answers(engine, asked) {
  const worlds = Object.fromEntries(Object.entries(asked.scenes).map(([name, scene]) => [name, new engine.World(scene, 10)]));
  return JSON.stringify({
    looks: asked.looks.map(look => looked(engine, worlds[look.scene], look)),
    runs: asked.runs.map(run => played(engine, worlds[run.scene], run)),
    landscapes: asked.landscapes.map(one => mapped(engine, worlds[one.scene], one)),
    streams: asked.seeds.map(seed => drawn(engine, seed)),
  });
}

function looked(engine, world, {demonstrator, learner}) {
  const {images: demo, seen: demoSeen} = world.look("demonstrator", demonstrator), {images: own, seen: ownSeen} = world.look("learner", learner);
  const usable = Array.from({length: demo.length / 4}, (_, i) => i).filter(
    i => demoSeen[2 * i] && demoSeen[2 * i + 1] && ownSeen[2 * i] && ownSeen[2 * i + 1]);
  const used = engine.select(demo, usable), usedOwn = engine.select(own, usable);
  const found = {images: {demo: numbers(demo), own: numbers(own), seen: [...demoSeen, ...ownSeen]}, usable};
  if (usable.length < engine.MIN_POINTS) return found;
  for (const [name, transfer] of Object.entries(engine.TRANSFERS)) {
    const fitted = transfer.fit(used, usedOwn), E = engine.conflict(engine.residual(fitted, used, usedOwn));
    found[name] = {E, recovered: numbers(fitted.recover(used)), condition: numbers([fitted.condition])[0]};
    if (fitted.f) found.f = numbers(fitted.f);
  }
  found.lines = new engine.EpipolarGeometry(used, usedOwn).lines(demo.subarray(12, 16), own.subarray(12, 16));
  return found;
}

function played(engine, world, {settings, motions, poses}) {
  const session = new engine.Session(world, settings), moments = [session.now];
  for (let k = 0; k < motions; k++) {
    if (poses[k]) session.pose(poses[k]);
    if (!session.step() && !Object.keys(poses).some(at => at > k)) break;
    moments.push(session.now);
  }
  return {theta: moments.map(({theta}) => theta), E: numbers(moments.map(({E}) => E)), status: session.now.status};
}

function mapped(engine, world, {transfer, demonstrator, step}) {
  const landscape = new engine.Landscape(world, step);
  landscape.evaluate(transfer, world.look("demonstrator", demonstrator));
  return {E: numbers(landscape.E), minimum: landscape.minimum};
}

function drawn(engine, seed) {
  const each = draw => {
    const random = new engine.Generator(seed);
    return Array.from({length: 200}, () => draw(random));
  };
  return {bits: each(random => String(random.next())), uniform: each(random => random.random()), normal: each(random => random.normal())};
}
