// Figures, scorers, methods, and the run as it was configured.
"use strict";

(() => {
  avs.views.figures = ({ parts }) => {
    const { figures } = avs.index;
    if (!figures.length) return avs.missing("This run has drawn no figure: snakemake figures draws them.");
    const sections = [...new Set(figures.map((figure) => figure.section))];
    const current = sections.includes(parts[1]) ? parts[1] : sections[0];
    return avs.h("section", { "aria-labelledby": "title" }, avs.h("h1", { id: "title" }, `Figures: ${current}`),
      avs.h("nav.tabs", { "aria-label": "Kinds of figures" }, sections.map((section) => avs.h("a", { href: avs.address(["figures", section]), "aria-current": section === current ? "page" : null }, section))),
      figures.filter((figure) => figure.section === current).map((figure) => avs.h("figure.panel.drawn", {}, avs.h("h2", {}, figure.title),
        avs.h("a", { href: `figures/${encodeURIComponent(figure.file)}` }, avs.h("img", { src: `figures/${encodeURIComponent(figure.file)}`, alt: figure.caption || figure.title, loading: "lazy" })),
        avs.h("figcaption", {}, figure.caption))));
  };

  avs.views.scorers = () => {
    const cards = Object.entries(avs.index.cards);
    if (!cards.length) return avs.missing("This run has trained no scorer.");
    return avs.h("section", { "aria-labelledby": "title" }, avs.h("h1", { id: "title" }, "Trained scorers"),
      avs.h("p.quiet", {}, "Networks that predict the SSIM of a rendering from photographs of other views, trained on renderings of training scenes, and tested on scenes that they have not seen. docs/scorer-study.md says what each number is."),
      avs.h("div.panels", {}, cards.map(([name, card]) => avs.panel(name, held(card), curve(card), avs.h("details", {}, avs.h("summary", {}, "Model card"), avs.tree(card))))));
  };

  function held(card) {
    const told = card.held_out;
    if (!told) return avs.missing("No scene was held out.");
    const names = { pearson: "Pearson, images", spearman: "Spearman, images", candidate_spearman: "Spearman, candidates of a moment", pixel_pearson: "Pearson, pixels", mean_absolute_error: "mean absolute error, images", images: "held-out renderings" };
    return avs.h("dl.facts", {}, Object.entries(names).filter(([key]) => key in told).map(([key, title]) => avs.h("div", {}, avs.h("dt", {}, title), avs.h("dd", {}, avs.short(told[key])))));
  }

  function curve(card) {
    const points = card.mean_absolute_error || [];
    if (points.length < 2) return null;
    const line = (key, colour, label, dashed) => ({ points: points.map((each) => [each.step, each[key]]), colour, label, dashed, strong: !dashed });
    return [avs.lineChart([line("held_out", "#D55E00", "held-out scenes", false), line("training", "#8a8a8a", "training scenes", true)], { x: "step", y: "mean absolute error of pixels", label: "error of the predicted SSIM over training steps" }),
      avs.h("p.quiet", {}, "Line: held-out scenes. Dashed: training scenes.")];
  }

  avs.views.methods = ({ parts }) => avs.h("section", { "aria-labelledby": "title" }, avs.h("h1", { id: "title" }, "Methods"),
    avs.h("p.quiet", {}, "What each method is, where it comes from, and in what it deviates: as its own file states it."),
    avs.index.methods.map((method) => avs.h("article.panel", { id: `method-${method.id}`, class: method.id === parts[1] ? "panel aimed" : "panel" },
      avs.h("h2", {}, avs.h("span.dot", { style: `background:${method.colour}`, "aria-hidden": "true" }), method.label, " ", avs.h("code", {}, method.id)),
      avs.h("p", {}, method.source),
      method.absent ? avs.missing(`Not in this run: ${method.absent}`) : null,
      avs.h("p.quiet", {}, [`group: ${method.group || "none"}`, method.ranked ? null : "not ranked", method.chooses ? `takes the ${method.chooses} score` : null, method.needs?.length ? `needs ${method.needs.join(", ")}` : "needs renderings only", method.scorer ? `scorer ${method.scorer}` : null, method.module ? `defined in ${method.module}` : null].filter(Boolean).join(" · ")),
      method.settings.length ? avs.h("details", {}, avs.h("summary", {}, `Settings (${method.settings.length})`), avs.h("dl.tree", {}, method.settings.map(([name, value, about]) => avs.h("div", {}, avs.h("dt", {}, name), avs.h("dd", {}, avs.h("code", {}, value), " ", about))))) : null)));

  avs.views.run = () => avs.h("section", { "aria-labelledby": "title" }, avs.h("h1", { id: "title" }, `Run ${avs.index.scale}`),
    avs.h("p", {}, `${avs.index.data_sets.length} data sets, ${avs.index.data_sets.reduce((sum, each) => sum + each.scenes.length, 0)} scenes, ${avs.index.methods.length} methods, ${avs.index.methods.filter((method) => method.absent).length} of which could not run.`),
    avs.h("ul", {}, avs.index.data_sets.map((each) => avs.h("li", {}, `${each.called}: ${each.scenes.join(", ")}`))),
    absent(),
    avs.panel("Configuration", avs.tree(avs.index.config)));

  function absent() {
    const found = avs.index.methods.filter((method) => method.absent);
    if (!found.length) return null;
    return avs.panel("Methods that could not run", avs.h("ul", {}, found.map((method) => avs.h("li", {}, avs.h("b", {}, `${method.label}: `), method.absent))));
  }
})();
