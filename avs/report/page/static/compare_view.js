// Two or more methods side by side on one scene with one seed, at the same number of captured views.
"use strict";

(() => {
  // Two methods may be of one group, whose colour they share elsewhere.
  const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
  const colourOf = (methods, method) => COLOURS[methods.indexOf(method) % COLOURS.length];
  const dot = (colour) => avs.h("span.dot", { style: `background:${colour}`, "aria-hidden": "true" });

  avs.views.compare = ({ parts, settings }) => {
    const sets = avs.index.data_sets.filter((each) => each.scenes.length);
    if (!sets.length) return avs.missing("This run has no scene.");
    const entry = sets.find((each) => each.name === parts[1]) || sets[0];
    const name = entry.scenes.includes(parts[2]) ? parts[2] : entry.scenes[0];
    return avs.later(avs.load(`${avs.place(entry.name, name)}/scene`), (scene) => chosen(scene, parts[3], settings), "loading the scene");
  };

  function chosen(scene, given, settings) {
    const all = Object.values(scene.episodes);
    if (!all.length) return avs.missing("No method has an episode of this scene.");
    const seeds = [...new Set(all.map((each) => each.seed))];
    const seed = seeds.includes(Number(given)) ? Number(given) : seeds[0];
    const there = all.filter((each) => each.seed === seed).map((each) => each.method);
    const asked = (settings.methods || "").split(",").filter((method) => there.includes(method));
    const methods = asked.length >= 2 ? asked : [...new Set([...asked, ...usual(scene, there, seed)])].slice(0, Math.max(2, asked.length));
    const go = (changes) => {
      const next = { dataset: scene.dataset, scene: scene.scene, seed, methods, ...changes };
      if (changes.dataset) next.scene = avs.index.data_sets.find((each) => each.name === changes.dataset).scenes[0];
      avs.go(["compare", next.dataset, next.scene, next.seed], { methods: next.methods.join(","), step: avs.parse(location.hash).settings.step });
    };
    const promise = Promise.all(methods.map((method) => avs.loadEpisode(scene.dataset, scene.scene, method, seed)));
    return avs.h("section", { "aria-labelledby": "title" },
      avs.h("h1", { id: "title" }, `Methods on ${scene.scene}, seed ${seed}`),
      choosers(scene, seeds, seed, methods, there, go),
      avs.later(promise, (loaded) => sideBySide(scene, seed, loaded, settings), "loading the episodes"));
  }

  // The two ranked methods that are farthest apart at the end: what there is to be seen is seen there.
  function usual(scene, there, seed) {
    const end = (method) => scene.episodes[`${method}-${seed}`].curve.at(-1)[3] ?? 0;
    const ranked = there.filter((method) => avs.methodOf(scene, method).ranked).sort((one, other) => end(other) - end(one));
    return ranked.length > 1 ? [ranked[0], ranked.at(-1)] : there;
  }

  function choosers(scene, seeds, seed, methods, there, go) {
    const sets = avs.index.data_sets;
    const boxes = scene.methods.filter((method) => there.includes(method.id)).map((method) => {
      const box = avs.h("input", { type: "checkbox", checked: methods.includes(method.id), onchange: () => {
        const next = box.checked ? [...methods, method.id] : methods.filter((each) => each !== method.id);
        if (next.length < 2) box.checked = true;
        else go({ methods: next });
      } });
      return avs.h("label.check", {}, box, methods.includes(method.id) ? dot(colourOf(methods, method.id)) : null, method.label);
    });
    return avs.h("form.filters", { onsubmit: (event) => event.preventDefault() },
      avs.select("Data set", sets.map((each) => [each.name, each.name]), scene.dataset, (dataset) => go({ dataset })),
      avs.select("Scene", sets.find((each) => each.name === scene.dataset).scenes.map((name) => [name, name]), scene.scene, (name) => go({ scene: name })),
      avs.select("Seed", seeds.map((each) => [String(each), String(each)]), String(seed), (value) => go({ seed: Number(value) })),
      avs.h("details.methods", {}, avs.h("summary", {}, `Methods (${methods.length})`), avs.h("div.checks", {}, boxes)));
  }

  // Moments are numbers of captured views, since methods that choose several at a time have fewer selections.
  function sideBySide(scene, seed, loaded, settings) {
    const counts = loaded.map((each) => [...Array(avs.moments(each.episode)).keys()].map((moment) => avs.capturedBefore(each.episode, moment).length));
    const moments = [...new Set(counts.flat())].sort((one, other) => one - other);
    const at = (place, views) => Math.max(0, counts[place].findLastIndex((count) => count <= views));
    const given = moments.indexOf(Number(settings.step));
    const state = { share: 50, test: 0 };
    const shown = loaded.map((each) => each.episode.method);
    const colours = Object.fromEntries(shown.map((method) => [method, colourOf(shown, method)]));
    const columns = loaded.map((each) => column(scene, each, colours[each.episode.method]));
    const [curve, images] = [avs.h("div"), avs.h("div")];
    const legend = avs.h("p.quiet.legend", {}, loaded.map((each) => [dot(colours[each.episode.method]), `${avs.methodOf(scene, each.episode.method).label} `]), "· thin: the other methods of this scene");
    let metric = "psnr";
    const measure = avs.select("Metric", Object.entries(avs.METRICS).map(([id, told]) => [id, told.name]), metric, (id) => { metric = id; draw(); });
    let now = given < 0 ? 0 : given;
    const player = avs.player(moments.length - 1, now, (moment) => `${moments[moment]} captured views`, (moment) => {
      now = moment;
      avs.keep({ step: moments[moment], methods: loaded.map((each) => each.episode.method).join(",") }, ["compare", scene.dataset, scene.scene, seed]);
      draw();
    });
    function draw() {
      for (const [place, each] of columns.entries()) {
        each.draw(at(place, moments[now]), state, (changes) => { Object.assign(state, changes); draw(); });
      }
      curve.replaceChildren(avs.curvePart(scene, seed, Object.keys(colours), metric, moments[now], colours), legend);
      images.replaceChildren(perImage(scene, loaded, moments[now], metric));
    }
    draw();
    return [player.element, avs.h("div.columns", { style: `--columns:${columns.length}` }, columns.map((each) => each.element)), avs.h("div.panels", {}, avs.panel("Test images over views", avs.h("form.filters", { onsubmit: (event) => event.preventDefault() }, measure), curve),
      avs.h("div.stack", {}, avs.panel("Test images one by one, at this number of views", images), agreement(scene, loaded)))];
  }

  function column(scene, loaded, colour) {
    const method = avs.methodOf(scene, loaded.episode.method);
    const space = avs.sceneSpace(scene.cameras, avs.scenePoints(scene.points), { label: `Cameras of ${method.label}`, height: 220 });
    const areas = Object.fromEntries(["words", "view", "scores", "strip"].map((name) => [name, avs.h("div")]));
    const element = avs.h("section.panel", {},
      avs.h("h2", {}, dot(colour),
        avs.h("a", { href: avs.address(["episode", scene.dataset, scene.scene, loaded.episode.method, loaded.episode.seed]) }, method.label)),
      areas.words, areas.view, areas.scores, space.element, areas.strip);
    const draw = (moment, state, redraw) => {
      const point = momentOf(loaded, moment);
      areas.words.replaceChildren(avs.h("p", {}, avs.momentText(loaded, moment), avs.h("br"), avs.h("b", {}, point)));
      areas.view.replaceChildren(...[avs.viewPart(loaded, moment, state, redraw)].flat().filter(Boolean));
      areas.scores.replaceChildren(avs.scorePart(loaded, moment, true));
      areas.strip.replaceChildren(avs.stripPart(loaded, moment));
      space.update(...avs.roles(loaded, moment));
    };
    return { element, draw };
  }

  // The test PSNR just before a selection, or at the end.
  function momentOf({ episode }, moment) {
    const point = avs.pointAt(episode, avs.capturedBefore(episode, moment).length);
    return point ? `test PSNR ${avs.fixed(avs.mean(point.psnr), 2)} dB` : "";
  }

  // Each test image with its value for every method at a number of views, those first in which the methods differ most. A
  // method that chooses several at a time is measured between its choices, too, or, on a schedule of its own, is not.
  function perImage(scene, loaded, views, metric) {
    const told = avs.METRICS[metric];
    const points = loaded.map(({ episode }) => avs.pointAt(episode, views));
    const without = loaded.filter((_, place) => !points[place]).map(({ episode }) => avs.methodOf(scene, episode.method).label);
    if (without.length) return avs.missing(`Not measured with ${views} views: ${without.join(", ")}.`);
    const rows = loaded[0].episode.test.map((camera, row) => ({ camera, values: points.map((point) => point[metric][row]) }))
      .filter(({ values }) => values.every((value) => value !== null));
    if (!rows.length) return avs.missing(`${told.name}: not measured`);
    const apart = ({ values }) => Math.max(...values) - Math.min(...values);
    rows.sort((one, other) => apart(other) - apart(one));
    const best = (values) => (told.higher ? Math.max : Math.min)(...values);
    return avs.h("div.scroll", {}, avs.h("table.numbers", {},
      avs.h("thead", {}, avs.h("tr", {}, avs.h("th.name", { scope: "col" }, `${told.name}${told.unit ? ` (${told.unit})` : ""}`), loaded.map((each) => avs.h("th", { scope: "col" }, avs.methodOf(scene, each.episode.method).label)))),
      avs.h("tbody", {}, rows.map(({ camera, values }) => avs.h("tr", {}, avs.h("th.name", { scope: "row" }, scene.names[camera]),
        values.map((value) => avs.h("td", {}, value === best(values) ? avs.h("b", {}, avs.fixed(value, told.decimals)) : avs.fixed(value, told.decimals))))))));
  }

  // How many of the selected views are the same, for each pair.
  function agreement(scene, loaded) {
    const label = (each) => avs.methodOf(scene, each.episode.method).label;
    const rows = loaded.flatMap((one, place) => loaded.slice(place + 1).map((other) => {
      const same = one.episode.selected.filter((camera) => other.episode.selected.includes(camera));
      return avs.h("li", {}, `${label(one)} and ${label(other)} selected ${same.length} of ${one.episode.selected.length} views in common${same.length ? `: ${same.map((camera) => scene.names[camera]).join(", ")}` : ""}.`);
    }));
    return avs.panel("Views in common", avs.h("ul", {}, rows));
  }
})();
