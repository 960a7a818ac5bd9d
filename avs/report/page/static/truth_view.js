// States at which all methods scored the same candidates: each method's scores against what the photographs say.
"use strict";

(() => {
  const TRUTHS = { ssim: "true SSIM", psnr: "true PSNR (dB)", gain: "gain of capturing it (dB)" };
  const SIZE = 190;
  const LEFT = 40;
  const MARGIN = 8;

  avs.views.truth = ({ parts, settings }) => {
    const sets = avs.index.data_sets.filter((each) => each.scenes.length);
    if (!sets.length) return avs.missing("This run has no scene.");
    const ranked = avs.index.tables.find((table) => table.name.startsWith("ranking_"));
    const usual = ranked ? ranked.name.replace("ranking_", "") : sets[0].name;
    const entry = sets.find((each) => each.name === (parts[1] || usual)) || sets[0];
    const name = entry.scenes.includes(parts[2]) ? parts[2] : entry.scenes[0];
    const place = avs.place(entry.name, name);
    const promise = avs.load(`${place}/scene`).then(async (scene) => {
      const seed = scene.states.includes(Number(parts[3])) ? Number(parts[3]) : scene.states[0];
      return { scene, seed, told: seed === undefined ? null : await avs.load(`${place}/states-${seed}`) };
    });
    return avs.later(promise, (loaded) => whole(loaded, sets, settings), "loading the states");
  };

  function whole({ scene, seed, told }, sets, settings) {
    const go = (changes) => {
      const next = { dataset: scene.dataset, scene: scene.scene, seed, ...changes };
      if (changes.dataset) next.scene = sets.find((each) => each.name === changes.dataset).scenes[0];
      avs.go(["truth", next.dataset, next.scene, next.seed ?? 0], { ...avs.parse(location.hash).settings });
    };
    const head = [avs.h("h1", { id: "title" }, `Scores against truth: ${scene.scene}`),
      avs.h("p.quiet", {}, "At each of these states all methods scored the same candidates of the same reconstruction. The truth is what the hidden photographs say: the quality of the candidate's rendering, or how much capturing it raises the test PSNR. The large dot is the candidate that the method takes. The correlation is that of the table: one means the very order of the truth, lowest quality or highest gain first."),
    ];
    const choosers = [
      avs.select("Data set", sets.map((each) => [each.name, each.name]), scene.dataset, (dataset) => go({ dataset })),
      avs.select("Scene", sets.find((each) => each.name === scene.dataset).scenes.map((each) => [each, each]), scene.scene, (name) => go({ scene: name })),
    ];
    if (!told) return avs.h("section", {}, head, avs.h("form.filters", {}, choosers), avs.missing("The run measured no common states of this scene (common_states of the configuration)."));
    const state = { place: Math.min(Number(settings.state) || 0, told.states.length - 1), truth: TRUTHS[settings.truth] ? settings.truth : "ssim" };
    const area = avs.h("div.scatters");
    const draw = () => area.replaceChildren(...told.methods.map((method) => panel(scene, told, method, state)));
    const change = (changes) => { Object.assign(state, changes); avs.keep({ state: state.place, truth: state.truth }, ["truth", scene.dataset, scene.scene, seed]); draw(); };
    draw();
    return avs.h("section", { "aria-labelledby": "title" }, head, avs.h("form.filters", { onsubmit: (event) => event.preventDefault() }, choosers,
      scene.states.length > 1 ? avs.select("Seed", scene.states.map((each) => [String(each), String(each)]), String(seed), (value) => go({ seed: Number(value) })) : null,
      avs.select("State", told.states.map((each, place) => [String(place), `${each.views} views`]), String(state.place), (value) => change({ place: Number(value) })),
      avs.select("Truth", Object.entries(TRUTHS), state.truth, (truth) => change({ truth }))), area);
  }

  function panel(scene, told, method, state) {
    const known = avs.methodOf(scene, method.id);
    const scores = method.scores[state.place];
    const truth = told.states[state.place][state.truth];
    const title = avs.h("h2", {}, avs.h("span.dot", { style: `background:${known ? known.colour : "#8a8a8a"}`, "aria-hidden": "true" }), method.label);
    if (!scores) return avs.h("section.panel", {}, title, avs.missing(method.failure || "no scores"));
    if (!truth) return avs.h("section.panel", {}, title, avs.missing("The gain was not measured."));
    const candidates = told.states[state.place].candidates;
    const taken = candidates[choice(scores, method.chooses)];
    const points = scores.map((score, place) => [score, truth[place], candidates[place]]).filter(([score, value]) => score !== null && value !== null);
    if (points.length < 3) return avs.h("section.panel", {}, title, avs.missing("Fewer than three candidates have both."));
    const shown = points.some(([, , camera]) => camera === taken) ? "" : `, of ${scene.names[taken]}, whose ${state.truth === "gain" ? "gain" : "truth"} was not measured`;
    return avs.h("section.panel", {}, title, scatter(points, scene, method, known, taken), avs.h("p.quiet", {}, `takes the ${method.chooses} score${shown}; rank correlation ${avs.signed(agreement(points, method.chooses, state.truth), 2)} over ${points.length} candidates${method.own_fit ? "; scored a fit of its own" : ""}`));
  }

  // The place of the candidate that a method takes: of equal scores the first, as the loop does.
  function choice(scores, chooses) {
    const known = scores.filter((score) => score !== null);
    return scores.indexOf((chooses === "lowest" ? Math.min : Math.max)(...known));
  }

  function scatter(points, scene, method, known, taken) {
    // Some scores lie decades apart: on an even axis all but the highest would be one dot.
    const even = points.map((point) => point[0]);
    const decades = Math.min(...even) > 0 && Math.max(...even) > 100 * Math.min(...even);
    const along = (value, axis) => (decades && axis === 0 ? Math.log10(value) : value);
    const ends = [0, 1].map((axis) => [Math.min(...points.map((point) => point[axis])), Math.max(...points.map((point) => point[axis]))]);
    const at = (value, axis) => MARGIN + ((along(value, axis) - along(ends[axis][0], axis)) / (along(ends[axis][1], axis) - along(ends[axis][0], axis) || 1)) * (SIZE - 2 * MARGIN);
    return avs.svg("svg", { viewBox: `${-LEFT} 0 ${SIZE + LEFT} ${SIZE + 14}`, class: "scatter", role: "img", "aria-label": `truth over score of ${method.label}` },
      avs.svg("rect", { x: 0, y: 0, width: SIZE, height: SIZE, class: "frame" }),
      points.map(([score, value, camera]) => avs.svg("circle", { cx: at(score, 0), cy: SIZE - at(value, 1), r: camera === taken ? 5 : 3, fill: known ? known.colour : "#8a8a8a", class: camera === taken ? "taken" : null },
        avs.svg("title", {}, `${scene.names[camera]}: score ${avs.short(score)}, truth ${avs.short(value)}${camera === taken ? "; taken" : ""}`))),
      avs.svg("text", { x: -4, y: 12, "text-anchor": "end" }, Number(ends[1][1].toPrecision(3))), avs.svg("text", { x: -4, y: SIZE - 3, "text-anchor": "end" }, Number(ends[1][0].toPrecision(3))),
      avs.svg("text", { x: 0, y: SIZE + 12 }, avs.short(ends[0][0])), avs.svg("text", { x: SIZE, y: SIZE + 12, "text-anchor": "end" }, `${avs.short(ends[0][1])} score${decades ? ", logarithmic" : ""}`));
  }

  // The rank correlation of the order in which a method takes candidates with the order of the truth.
  function agreement(points, chooses, truth) {
    const found = spearman(points);
    return found === null || (chooses === "highest") === (truth === "gain") ? found : -found;
  }

  // The correlation of ranks; equal values share the mean of their ranks.
  function spearman(points) {
    const [one, other] = [0, 1].map((axis) => ranks(points.map((point) => point[axis])));
    const [middle, further] = [avs.mean(one), avs.mean(other)];
    const sum = (function_) => one.reduce((total, _, place) => total + function_(one[place] - middle, other[place] - further), 0);
    const norm = Math.sqrt(sum((a) => a * a) * sum((a, b) => b * b));
    return norm ? sum((a, b) => a * b) / norm : null;
  }

  function ranks(values) {
    return values.map((value) => values.filter((each) => each < value).length + (values.filter((each) => each === value).length + 1) / 2);
  }
})();
