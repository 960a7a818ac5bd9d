// All episodes of a data set, or those of one method: methods by scenes, each value a link to its episode.
"use strict";

(() => {
  avs.views.episodes = ({ parts, settings }) => {
    const sets = avs.index.data_sets.filter((each) => each.scenes.length);
    if (!sets.length) return avs.missing("This run has no scene.");
    const entry = sets.find((each) => each.name === parts[1]) || sets[0];
    const metric = avs.METRICS[settings.metric] ? settings.metric : "psnr";
    const go = (changes) => avs.go(["episodes", changes.dataset || entry.name], { ...settings, scene: changes.dataset ? null : settings.scene, ...changes, dataset: null });
    const promise = Promise.all(entry.scenes.map((scene) => avs.load(`${avs.place(entry.name, scene)}/scene`)));
    return avs.h("section", { "aria-labelledby": "title" },
      avs.h("h1", { id: "title" }, `Episodes of ${entry.name}`), avs.h("p.quiet", {}, `${entry.called}. A number is the mean over the test images at the end of one episode; it leads there.`),
      avs.h("form.filters", { onsubmit: (event) => event.preventDefault() },
        avs.select("Data set", sets.map((each) => [each.name, each.name]), entry.name, (dataset) => go({ dataset })),
        avs.select("Scene", [["", "all"], ...entry.scenes.map((name) => [name, name])], settings.scene || "", (scene) => go({ scene })),
        avs.select("Metric", Object.entries(avs.METRICS).map(([key, each]) => [key, each.name]), metric, (value) => go({ metric: value })),
        settings.method ? avs.h("a.button", { href: avs.address(["episodes", entry.name], { ...settings, method: null }) }, "all methods") : null),
      avs.later(promise, (scenes) => grid(scenes.filter((each) => !settings.scene || each.scene === settings.scene), metric, settings.method)));
  };

  function grid(scenes, metric, only) {
    if (!scenes.length) return avs.missing("There is no such scene.");
    const columns = scenes.flatMap((scene) => [...new Set(Object.values(scene.episodes).map((each) => each.seed))].map((seed) => ({ scene, seed })));
    const methods = scenes[0].methods.filter((method) => !only || method.id === only);
    const told = avs.METRICS[metric];
    const place = { psnr: 3, ssim: 4, lpips: 5 }[metric];
    return avs.h("div.scroll", { tabindex: "0", role: "region", "aria-label": "episodes, scrolls sideways" }, avs.h("table.numbers", {},
      avs.h("thead", {},
        avs.h("tr.over", {}, avs.h("th", {}, ""), scenes.map((scene) => avs.h("th", { colspan: columns.filter((each) => each.scene === scene).length, scope: "colgroup" }, scene.scene))),
        avs.h("tr", {}, avs.h("th.name", { scope: "col" }, "Method"), columns.map(({ seed }) => avs.h("th", { scope: "col" }, `seed ${seed}`)))),
      avs.h("tbody", {}, methods.map((method) => avs.h("tr", {},
        avs.h("th.name", { scope: "row" }, avs.h("span.dot", { style: `background:${method.colour}`, "aria-hidden": "true" }), method.label),
        method.absent ? avs.h("td.cause", { colspan: columns.length }, method.absent) : columns.map(({ scene, seed }) => cell(scene, method, seed, place, told)))))));
  }

  function cell(scene, method, seed, place, told) {
    const found = scene.episodes[`${method.id}-${seed}`];
    if (!found) return avs.h("td", { title: "there is no record of this episode" }, avs.DASH);
    const value = found.curve.at(-1)[place];
    return avs.h("td", {}, avs.h("a", { href: avs.address(["episode", scene.dataset, scene.scene, method.id, seed], { metric: told === avs.METRICS.psnr ? null : told.name.toLowerCase() }) }, avs.fixed(value, told.decimals)));
  }
})();
