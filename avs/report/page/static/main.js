// Which view the address names, the navigation, and the keys of the page.
"use strict";

(() => {
  const VIEWS = {
    tables: "Tables", episodes: "Episodes", episode: "Replay", compare: "Compare", truth: "Scores", figures: "Figures", slam: "SLAM", scorers: "Scorers", methods: "Methods", run: "Run",
  };
  const KINDS = ["INPUT", "SELECT", "TEXTAREA", "CANVAS"];

  // Parts that a run need not have; scores against truth are of the states that its tables ranking_* are made from.
  const THERE = {
    truth: () => avs.index.tables.some((table) => table.name.startsWith("ranking_")),
    slam: () => Object.keys(avs.index.explorations).length > 0,
    scorers: () => Object.keys(avs.index.cards).length > 0,
  };
  const shown = () => Object.entries(VIEWS).filter(([key]) => !THERE[key] || THERE[key]());

  function draw() {
    const place = document.getElementById("content");
    if (!avs.index) {
      place.replaceChildren(avs.missing("index.js cannot be loaded; copy the whole folder of the report."));
      return;
    }
    const route = avs.parse(location.hash);
    const name = avs.views[route.parts[0]] ? route.parts[0] : "tables";
    avs.onkey = null;
    document.querySelector("header nav").replaceChildren(...shown().map(([key, title]) => avs.h("a", { href: avs.address([key]), "aria-current": key === name ? "page" : null }, title)));
    document.title = `${VIEWS[name]}: active view selection, ${avs.index.scale}`;
    place.replaceChildren(...[avs.views[name](route)].flat(Infinity).filter(Boolean));
  }

  let earlier = null;
  window.addEventListener("hashchange", () => {
    draw();
    const [name] = avs.parse(location.hash).parts;
    if (name !== earlier) { // another part of the page: its beginning, also for readers of the keyboard and the ear
      window.scrollTo(0, 0);
      document.getElementById("content").focus({ preventScroll: true });
    }
    earlier = name;
  });
  document.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey || KINDS.includes(event.target.tagName)) return;
    if (avs.onkey && ["ArrowLeft", "ArrowRight"].includes(event.key) && !event.target.closest("[tabindex]:not(main), nav")) {
      event.preventDefault();
      avs.onkey(event);
    }
  });
  document.addEventListener("DOMContentLoaded", draw);
  window.avs = avs;
})();
