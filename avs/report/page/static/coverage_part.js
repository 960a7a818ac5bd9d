// What the views of an episode cover: numbers, and the reference cloud coloured by its distance to the views' own.
"use strict";

(() => {
  // From well covered (blue) over the threshold (pale) to missed (red), for readers with any colour vision.
  const STOPS = [[49, 84, 165], [160, 195, 220], [245, 235, 200], [235, 150, 80], [180, 20, 40]];

  function coloured(levels) {
    const colours = new Uint8Array(levels.length * 3);
    for (const [place, level] of levels.entries()) {
      const at = (level / 255) * (STOPS.length - 1);
      const from = Math.min(Math.floor(at), STOPS.length - 2);
      for (let channel = 0; channel < 3; channel += 1) {
        colours[place * 3 + channel] = STOPS[from][channel] + (at - from) * (STOPS[from + 1][channel] - STOPS[from][channel]);
      }
    }
    return colours;
  }

  avs.coveragePart = ({ place, scene, episode }) => {
    const told = episode.coverage;
    if (!told) return avs.missing("Coverage was not measured for this episode.");
    const rows = [["against the cloud of all views", told.reference], ["against the true surface", told.surface]];
    const reason = Object.values(told.absent)[0];
    const numbers = avs.h("table.numbers.small", {}, avs.h("thead", {}, avs.h("tr", {}, ["", "SCR (%)", "F-score"].map((title) => avs.h("th", { scope: "col" }, title)))),
      avs.h("tbody", {}, rows.map(([name, values]) => avs.h("tr", {}, avs.h("th.name", { scope: "row" }, name),
        values ? [avs.h("td", {}, avs.fixed(values.scr * 100, 2)), avs.h("td", {}, avs.fixed(values.f_score, 3))] : avs.h("td.cause", { colspan: 2 }, reason || "not measured")))));
    const area = avs.h("div", {}, avs.h("button", { type: "button", onclick: () => area.replaceChildren(cloud(place, scene, episode)) }, "show the cloud"));
    return [numbers, avs.h("p.quiet", {}, `${told.registered} views reconstructed; SCR: share of the points nearer than ${avs.short(told.threshold * 100)} % of the extent.`),
      told.distances ? area : avs.missing(reason || "There is no cloud."), notes(told)];
  };

  function cloud(place, scene, episode) {
    return avs.later(avs.load(`${place}/cloud`), (told) => {
      const points = { xyz: told.xyz, colours: coloured(avs.bytes(episode.coverage.distances)), size: 2.4 };
      const space = avs.sceneSpace(scene.cameras, points, { label: "Reference cloud, coloured by the distance to the cloud of this episode's views" });
      space.update(...avs.roles({ scene, episode }, episode.steps.length).map((each) => (Array.isArray(each) ? each.map((role) => (role === "candidate" || role === "test" ? null : role)) : each)));
      const gradient = STOPS.map((stop) => `rgb(${stop.join(",")})`).join(",");
      return [space.element, avs.h("p.scale", {}, "a tenth of the threshold", avs.h("span", { style: `background:linear-gradient(90deg,${gradient})`, "aria-hidden": "true" }), "ten times it"),
        avs.h("p.quiet", {}, `${(told.xyz.length / 3).toLocaleString("en")} of ${told.points.toLocaleString("en")} points of the reference.`)];
    });
  }

  function notes(told) {
    const lines = [...told.notes, ...Object.entries(told.left_out).map(([view, why]) => `${view}: ${why}`)];
    return lines.length ? avs.h("ul.quiet", {}, lines.map((line) => avs.h("li", {}, line))) : null;
  }
})();
