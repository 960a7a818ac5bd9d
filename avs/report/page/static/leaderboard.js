// The tables of the run: a list of all, and one of them with its filters; and the episodes behind a cell.
"use strict";

(() => {
  avs.views.tables = ({ parts, settings }) => {
    const { tables } = avs.index;
    if (!tables.length) return avs.missing("This run has made no table.");
    const current = tables.find((table) => table.name === parts[1]) || tables[0];
    if (parts[1] && current.name !== parts[1]) return avs.missing(`There is no table ${parts[1]} in this run.`);
    return avs.h("div.split", {}, tableList(tables, current), avs.h("section.wide", { "aria-labelledby": "title" },
      avs.h("h1", { id: "title" }, avs.h("span.quiet", {}, `${current.section}: `), current.title),
      avs.later(avs.load(`tables/${current.name}`), (told) => interactive(current.name, told, { ...settings })),
      avs.h("p.quiet", {}, `Files: tables/${current.name}.csv, .md, .tex and .json in the results of the run; docs/tables.md says how each number is computed.`)));
  };

  function tableList(tables, current) {
    const sections = [...new Set(tables.map((table) => table.section))];
    return avs.h("nav.list", { "aria-label": "Tables" }, sections.map((section) => avs.h("div", {}, avs.h("h2", {}, section),
      avs.h("ul", {}, tables.filter((table) => table.section === section).map((table) => avs.h("li", {},
        avs.h("a", { href: avs.address(["tables", table.name]), "aria-current": table === current ? "page" : null }, table.title)))))));
  }

  // The table with its filters; changes go to the address, and only the table is drawn again.
  function interactive(name, told, state) {
    const place = avs.h("div", { "aria-live": "polite" });
    const redraw = (changes) => {
      Object.assign(state, changes);
      avs.keep(changes, ["tables", name]);
      draw();
    };
    function draw() {
      const shown = avs.filtered(told, state);
      const onsort = (sort, direction) => redraw({ sort: sort, dir: direction });
      const focused = document.activeElement && document.activeElement.closest("th button") ? [...place.querySelectorAll("th button")].indexOf(document.activeElement) : -1;
      place.replaceChildren(...avs.tableView(shown, { sort: state.sort, direction: state.dir, onsort, link: linkOf(name, told, state), colour: colourOf }).filter(Boolean));
      if (focused >= 0) place.querySelectorAll("th button")[focused]?.focus();
      if (!shown.groups.length) place.append(avs.missing("No row fits these filters."));
    }
    draw();
    return [filters(told, state, redraw), place];
  }

  function colourOf(identifier) {
    return avs.index.methods.find((method) => method.id === identifier)?.colour || null;
  }

  function filters(told, state, redraw) {
    const singles = avs.singles(told);
    const byEpisode = singles.length && told.columns.some((column) => singles.some((each) => each.metric === column.metric.identifier));
    const scenes = byEpisode ? [...new Set(singles.map((each) => each.scene))] : [];
    const seeds = byEpisode ? [...new Set(singles.filter((each) => each.seed !== undefined).map((each) => String(each.seed)))] : [];
    const groups = told.groups.map((group) => group.name).filter(Boolean);
    const all = (options, words) => [["", words], ...options.map((option) => [option, option])];
    const input = avs.h("input", { type: "search", value: state.method || "", placeholder: "name, name", oninput: () => redraw({ method: input.value }) });
    const rows = told.groups.flatMap((group) => group.rows).length;
    return avs.h("form.filters", { onsubmit: (event) => event.preventDefault() },
      scenes.length > 1 ? avs.select("Scene", all(scenes, `all ${scenes.length}`), state.scene || "", (scene) => redraw({ scene })) : null,
      seeds.length > 1 ? avs.select("Seed", all(seeds, `all ${seeds.length}`), state.seed || "", (seed) => redraw({ seed })) : null,
      groups.length > 1 ? avs.select("Group", all(groups, "all"), state.group || "", (group) => redraw({ group })) : null,
      rows > 3 ? avs.h("label.field", {}, avs.h("span", {}, told.rows_are), input) : null);
  }

  // A cell leads to its episodes: to the one that it is of, or to the list of them.
  function linkOf(name, told, state) {
    const dataset = /^(?:nvs|coverage)_(.+)$/.exec(name)?.[1];
    if (!dataset) return null;
    const singles = avs.singles(told);
    return (row) => {
      const own = singles.filter((each) => each.method === row.identifier && (!state.scene || each.scene === state.scene) && (!state.seed || String(each.seed) === state.seed));
      const found = [...new Map(own.map((each) => [`${each.scene}/${each.seed}`, each])).values()];
      if (!found.length) return null;
      if (found.length === 1) return avs.address(["episode", dataset, found[0].scene, row.identifier, found[0].seed]);
      return avs.address(["episodes", dataset], { method: row.identifier, scene: state.scene });
    };
  }
})();
