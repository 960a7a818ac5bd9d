// An exploration, replayed: the building from above, the robot's way, its candidates, and what was covered.
"use strict";

(() => {
  avs.views.slam = ({ parts, settings }) => {
    const buildings = Object.keys(avs.index.explorations);
    if (!buildings.length) return avs.missing("This run explores no building (slam of the configuration).");
    const building = buildings.includes(parts[1]) ? parts[1] : buildings[0];
    const runs = avs.index.explorations[building];
    const [method, seed] = runs.find(([name, number]) => name === parts[2] && String(number) === parts[3]) || runs[0] || [];
    if (method === undefined) return avs.missing(`No robot has explored ${building}.`);
    const promise = Promise.all(runs.map(([name, number]) => avs.load(`slam/${building}/${name}-${number}`)));
    return avs.later(promise, (found) => { const all = toldApart(found); return whole(building, runs, all, all.find((each) => each.method === method && each.seed === seed), settings); }, "loading the exploration");
  };

  // As in the tables: where methods have one name, such as one with two settings, their identifiers are beside it.
  function toldApart(all) {
    const names = new Map(all.map((each) => [each.method, each.label]));
    const shared = (label) => [...names.values()].filter((other) => other === label).length > 1;
    return all.map((each) => (shared(each.label) ? { ...each, label: `${each.label} (${each.method})` } : each));
  }

  function whole(building, runs, all, told, settings) {
    const go = (changes) => {
      const next = { building, method: told.method, seed: told.seed, ...changes };
      const found = avs.index.explorations[next.building].find(([name, number]) => name === next.method && number === next.seed) || avs.index.explorations[next.building].find(([name]) => name === next.method) || avs.index.explorations[next.building][0];
      avs.go(["slam", next.building, ...found]);
    };
    const map = floorMap(told);
    const last = told.decisions.length;
    let now = Math.min(Math.max((Number(settings.step) || 1) - 1, 0), last);
    const [words, curve] = [avs.h("div"), avs.h("div")];
    const player = avs.player(last, now, (moment) => momentText(told, moment), (moment) => { now = moment; avs.keep({ step: moment + 1 }, ["slam", building, told.method, told.seed]); draw(); });
    function draw() {
      map.draw(now);
      words.replaceChildren(decision(told, now));
      curve.replaceChildren(coverage(all.filter((each) => each.seed === told.seed), told, stepOf(told, now)));
    }
    draw();
    const seeds = runs.filter(([name]) => name === told.method).map(([, number]) => [String(number), String(number)]);
    return avs.h("section", { "aria-labelledby": "title" },
      avs.h("h1", { id: "title" }, `${told.label} explores ${building}, seed ${told.seed}`),
      avs.h("form.filters", { onsubmit: (event) => event.preventDefault() },
        avs.select("Building", Object.keys(avs.index.explorations).map((name) => [name, name]), building, (name) => go({ building: name })),
        avs.select("Method", [...new Map(all.map((each) => [each.method, each.label]))], told.method, (method) => go({ method })),
        avs.select("Seed", seeds, String(told.seed), (value) => go({ seed: Number(value) }))),
      facts(told), player.element,
      avs.h("div.panels", {}, avs.panel("From above", map.element, avs.h("p.quiet", {}, "Orange: the way so far. Rings: candidates of this decision; filled: the chosen one. Green: frontiers.")),
        avs.panel("This decision", words), avs.panel("Covered surface over actions", curve)),
      told.notes.length ? avs.h("ul.quiet", {}, told.notes.map((note) => avs.h("li", {}, note))) : null,
      avs.h("details.panel", {}, avs.h("summary", {}, "Provenance and settings"), avs.tree(told.provenance), avs.tree(told.settings)));
  }

  const stepOf = (told, moment) => told.decisions[moment]?.step ?? told.steps;

  function momentText(told, moment) {
    const found = told.decisions[moment];
    return found ? `Decision ${moment + 1} of ${told.decisions.length}, after ${found.step} actions` : `End after ${told.steps} actions: ${told.ended}`;
  }

  function facts(told) {
    const percent = (value) => (value === null ? avs.DASH : `${avs.fixed(value * 100, 2)} %`);
    const rows = [["SCR", percent(told.final.scr_means)], ["SCR (depth)", percent(told.final.scr_fused)], ["seen", percent(told.final.seen)], ["PSNR", told.final.psnr === null ? avs.DASH : `${avs.fixed(told.final.psnr, 2)} dB`], ["way", `${avs.fixed(told.final.path_length, 1)} m`], ["collisions", String(told.final.collisions)]];
    return avs.h("dl.facts", {}, rows.map(([name, value]) => avs.h("div", {}, avs.h("dt", {}, name), avs.h("dd", {}, value))));
  }

  function decision(told, moment) {
    const found = told.decisions[moment];
    if (!found) return avs.h("p", {}, `${told.surface_points.toLocaleString("en")} points of the surface can be seen from the floor; ${avs.fixed(told.floor_area, 1)} m² of it.`);
    const chosen = found.paths[found.chosen];
    const bars = { candidates: found.paths.map((_, place) => place), scores: found.paths.map((path) => path.score), chosen: [found.chosen] };
    const names = found.paths.map((path, place) => `path ${place + 1} to candidate ${path.candidate + 1}, ${avs.short(path.length)} m`);
    return avs.h("div", {}, avs.h("p", {}, `${found.candidates.length} candidates, ${found.paths.length} paths were scored; the chosen one is ${avs.short(chosen.length)} m long, of which ${found.executed} actions were done; ${found.gaussians.toLocaleString("en")} Gaussians in the map.`),
      avs.scoreBars(bars, { chooses: "highest", names, byScore: true, measures: null }));
  }

  function coverage(all, told, mark) {
    const colours = ["#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#000000"];
    const lines = all.map((each, place) => ({ label: each.label, colour: each.method === told.method ? "#D55E00" : colours[place % colours.length], strong: each.method === told.method, points: each.curve.map((point) => [point[0], point[1] * 100]) }));
    return [avs.lineChart(lines, { x: "actions", y: "SCR (%)", mark, label: "covered surface over actions" }),
      avs.h("p.quiet.legend", {}, lines.map((line) => [avs.h("span.dot", { style: `background:${line.colour}`, "aria-hidden": "true" }), `${line.label} `]))].reduce((place, child) => { place.append(child); return place; }, avs.h("div"));
  }

  // The picture from above with the way and the candidates drawn over it, in metres.
  function floorMap(told) {
    const [width, height] = told.above.size;
    const at = ([x, y]) => [x - told.above.origin[0], height - (y - told.above.origin[1])];
    const over = avs.svg("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
    const element = avs.h("div.floor", {}, avs.h("img", { src: told.above.picture, alt: `the building ${told.building} from above` }), over);
    const draw = (moment) => {
      const found = told.decisions[moment];
      const way = told.way.slice(0, stepOf(told, moment) + 1).map((place) => at(place).map((value) => value.toFixed(3)).join(","));
      const marks = [avs.svg("polyline", { points: way.join(" "), class: "way" })];
      for (const frontier of found?.frontiers || []) marks.push(avs.svg("rect", frontierBox(at(frontier)), avs.svg("title", {}, "frontier")));
      for (const [place, candidate] of (found?.candidates || []).entries()) {
        const taken = found.paths[found.chosen].candidate === place;
        const [cx, cy] = at(candidate);
        marks.push(avs.svg("circle", { cx, cy, r: taken ? 0.14 : 0.07, class: taken ? "taken" : "offered" }));
      }
      const here = at(told.way[Math.min(stepOf(told, moment), told.way.length - 1)]);
      marks.push(avs.svg("circle", { cx: here[0], cy: here[1], r: 0.12, class: "robot" }));
      over.replaceChildren(...marks);
    };
    return { element, draw };
  }

  function frontierBox([x, y]) {
    return { x: x - 0.08, y: y - 0.08, width: 0.16, height: 0.16, class: "frontier" };
  }
})();
