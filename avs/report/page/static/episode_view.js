// One episode, replayed: what was captured, how candidates were scored, what the model saw, and where it all comes from.
"use strict";

(() => {
  avs.views.episode = ({ parts, settings }) => {
    const [, dataset, scene, method, seed] = parts;
    const entry = avs.index.data_sets.find((each) => each.name === dataset);
    if (!entry || !entry.scenes.includes(scene)) return start();
    const promise = method === undefined
      ? avs.load(`${avs.place(dataset, scene)}/scene`).then((told) => first(told, dataset, scene))
      : avs.loadEpisode(dataset, scene, method, seed);
    return avs.later(promise, (loaded) => (loaded ? whole(loaded, settings) : avs.missing("No method has an episode of this scene.")), "loading the episode");
  };

  // Without a scene in the address: the first one.
  function start() {
    const entry = avs.index.data_sets.find((each) => each.scenes.length);
    if (!entry) return avs.missing("This run has no scene.");
    return avs.views.episode({ parts: ["episode", entry.name, entry.scenes[0]], settings: {} });
  }

  function first(told, dataset, scene) {
    const found = Object.values(told.episodes)[0];
    return found ? avs.loadEpisode(dataset, scene, found.method, found.seed) : null;
  }

  function whole(loaded, settings) {
    const { scene, episode } = loaded;
    const last = avs.moments(episode) - 1;
    const given = settings.step === undefined ? 1 : Number(settings.step) || 1;
    const state = { moment: Math.min(Math.max(given - 1, 0), last), byScore: settings.order !== "names", metric: avs.METRICS[settings.metric] ? settings.metric : "psnr", share: 50 };
    const method = avs.methodOf(scene, episode.method);
    const place = ["episode", scene.dataset, scene.scene, episode.method, episode.seed];
    const space = avs.sceneSpace(scene.cameras, avs.scenePoints(scene.points), { label: "Cameras in space" });
    const areas = Object.fromEntries(["view", "scores", "strip", "curve"].map((name) => [name, avs.h("div")]));
    const player = avs.player(last, state.moment, (moment) => avs.momentText(loaded, moment), (moment) => {
      state.moment = moment;
      avs.keep({ step: moment + 1 }, place);
      draw();
    });
    const redraw = (changes) => { Object.assign(state, changes); draw(); };
    function draw() {
      areas.view.replaceChildren(...[avs.viewPart(loaded, state.moment, state, redraw)].flat().filter(Boolean));
      areas.scores.replaceChildren(avs.scorePart(loaded, state.moment, state.byScore));
      areas.strip.replaceChildren(avs.stripPart(loaded, state.moment));
      areas.curve.replaceChildren(avs.curvePart(scene, episode.seed, [episode.method], state.metric, avs.capturedBefore(episode, state.moment).length));
      space.update(...avs.roles(loaded, state.moment));
    }
    draw();
    const order = avs.select("Order", [["score", "by score"], ["names", "by name"]], state.byScore ? "score" : "names", (value) => { avs.keep({ order: value === "names" ? value : null }, place); redraw({ byScore: value === "score" }); });
    const metric = avs.select("Metric", Object.entries(avs.METRICS).map(([key, each]) => [key, each.name]), state.metric, (value) => { avs.keep({ metric: value }, place); redraw({ metric: value }); });
    return avs.h("section.episode", { "aria-labelledby": "title" },
      avs.h("h1", { id: "title" }, avs.h("span.dot", { style: `background:${method.colour}`, "aria-hidden": "true" }), `${method.label} on ${scene.scene}, seed ${episode.seed}`),
      avs.chooser(loaded),
      result(loaded),
      player.element,
      avs.h("div.panels", {},
        panel("The chosen view", areas.view),
        panel("Scores of the candidates", order, areas.scores),
        panel("Cameras in space", space.element, avs.spaceLegend(["initial", "captured", "chosen", "candidate", "test"])),
        panel("Test images over views", metric, areas.curve, avs.h("p.quiet", {}, "Bold: this episode. Thin: the other methods on this scene with this seed, in the colours of their groups."))),
      panel("Captured photographs", areas.strip),
      avs.h("div.panels", {}, panel("The final model", avs.splatPart(loaded)), panel("Coverage by the views", avs.coveragePart(loaded))),
      panel("Views as text", avs.copyText("views in the order of capture", viewsText(loaded))),
      avs.provenance(loaded));
  }

  function panel(title, ...children) {
    return avs.h("section.panel", {}, avs.h("h2", {}, title), children);
  }
  avs.panel = panel;

  // Links to the neighbours: data set, scene, method, seed.
  avs.chooser = ({ scene, episode }) => {
    const go = (changes) => {
      const next = { dataset: scene.dataset, scene: scene.scene, method: episode.method, seed: episode.seed, ...changes };
      if (changes.dataset) next.scene = avs.index.data_sets.find((each) => each.name === changes.dataset).scenes[0];
      const same = next.dataset === scene.dataset && next.scene === scene.scene;
      const found = !same || scene.episodes[`${next.method}-${next.seed}`];
      const other = Object.values(scene.episodes).find((each) => each.method === next.method);
      avs.go(["episode", next.dataset, next.scene, next.method, found ? next.seed : other.seed], { step: avs.parse(location.hash).settings.step });
    };
    const sets = avs.index.data_sets;
    const has = (method) => Object.values(scene.episodes).some((each) => each.method === method.id);
    const seeds = Object.values(scene.episodes).filter((each) => each.method === episode.method).map((each) => String(each.seed));
    return avs.h("form.filters", { onsubmit: (event) => event.preventDefault() },
      avs.select("Data set", sets.map((each) => [each.name, each.name]), scene.dataset, (dataset) => go({ dataset })),
      avs.select("Scene", sets.find((each) => each.name === scene.dataset).scenes.map((name) => [name, name]), scene.scene, (name) => go({ scene: name })),
      avs.select("Method", scene.methods.filter(has).map((method) => [method.id, method.label]), episode.method, (method) => go({ method })),
      avs.select("Seed", seeds.map((seed) => [seed, seed]), String(episode.seed), (seed) => go({ seed: Number(seed) })),
      avs.h("a.button", { href: avs.address(["compare", scene.dataset, scene.scene, episode.seed], { methods: episode.method }) }, "compare"));
  };

  function result({ scene, episode }) {
    const last = scene.episodes[`${episode.method}-${episode.seed}`].curve.at(-1);
    const values = ["psnr", "ssim", "lpips"].map((metric, place) => {
      const told = avs.METRICS[metric];
      const value = last[3 + place];
      const why = value === null ? episode.absent[metric] || "not measured" : null;
      return avs.h("div", { title: why }, avs.h("dt", {}, told.name), avs.h("dd", {}, value === null ? avs.DASH : `${avs.fixed(value, told.decimals)} ${told.unit}`), why ? avs.h("dd.why", {}, why) : null);
    });
    const facts = [["views", last[0]], ["iterations", last[1].toLocaleString("en")], ["Gaussians", last[2].toLocaleString("en")]];
    return [avs.h("dl.facts", {}, values, facts.map(([name, value]) => avs.h("div", {}, avs.h("dt", {}, name), avs.h("dd", {}, String(value))))),
      episode.notes.length ? avs.h("ul.quiet", {}, episode.notes.map((note) => avs.h("li", {}, note))) : null];
  }

  function viewsText({ scene, episode }) {
    // As JSON, as views.json has them: names may hold blanks.
    const listed = (cameras) => `[${cameras.map((camera) => JSON.stringify(scene.names[camera])).join(", ")}]`;
    return [`# ${episode.label} (${episode.method}) on ${scene.dataset}/${scene.scene}, seed ${episode.seed}`, `# scene ${scene.hash}`,
      `initial: ${listed(episode.initial)}`, `selected: ${listed(episode.selected)}`].join("\n");
  }
})();
