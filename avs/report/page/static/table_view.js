// A table of the run as the tables' files have it: groups, ranks, the paper's values beside, notes; sortable by any column.
"use strict";

(() => {
  const MARKS = { 1: "best", 2: "second best", 3: "third best" };

  // Draws a document. `options`: sort and direction, onsort(key, direction), link(row, column) as an address or null.
  avs.tableView = (told, options = {}) => {
    const grouped = told.groups.map((group) => ({ ...group, rows: [...group.rows] }));
    const blocks = options.sort ? sortedBlocks(told, grouped, options) : grouped;
    const columns = told.columns.flatMap((column, place) => headings(column, place));
    const hasGroups = told.groups.some((group) => group.name || group.metric);
    return [
      avs.h("div.scroll", { tabindex: "0", role: "region", "aria-label": "table, scrolls sideways" },
        avs.h("table.numbers", {},
          avs.h("caption", {}, told.caption.join(" ")),
          avs.h("thead", {}, overRow(told.columns, hasGroups), avs.h("tr", {},
            hasGroups ? avs.h("th.group", { scope: "col" }, "") : null,
            sortHeading({ key: "label", title: told.rows_are, text: true }, options),
            columns.map((column) => sortHeading(column, options)))),
          blocks.map((group) => avs.h("tbody", {}, group.rows.map((row, place) => tableRow(told, group, row, place, hasGroups, options)))))),
      legend(told),
      comparison(told),
      notes(told),
    ];
  };

  function headings(column, place) {
    const { metric } = column;
    const arrow = { true: " ↑", false: " ↓", null: "" }[metric.higher_is_better];
    const unit = metric.unit ? ` (${metric.unit})` : "";
    const first = { key: `${place}`, title: `${metric.name}${arrow}${unit}`, about: metric.description, higher: metric.higher_is_better };
    const found = [first];
    if (column.published) found.push({ key: `${place}.published`, title: column.published, higher: metric.higher_is_better, quiet: true });
    if (column.difference) found.push({ key: `${place}.difference`, title: "difference", higher: true, quiet: true });
    return found;
  }

  function overRow(columns, hasGroups) {
    if (!columns.some((column) => column.over)) return null;
    const cells = [];
    for (const [place, column] of columns.entries()) {
      const span = headings(column, place).length;
      const last = cells.at(-1);
      if (last && last.over === column.over) last.span += span;
      else cells.push({ over: column.over, span });
    }
    return avs.h("tr.over", {}, hasGroups ? avs.h("th.group", {}, "") : null, avs.h("th", {}, ""),
      cells.map((cell) => avs.h("th", { colspan: cell.span, scope: "colgroup" }, cell.over || "")));
  }

  function sortHeading(column, options) {
    const sorted = options.sort === column.key;
    const direction = sorted ? options.direction : null;
    const next = nextDirection(column, direction);
    const inside = options.onsort
      ? avs.h("button", { type: "button", title: column.about || null, onclick: () => options.onsort(next ? column.key : null, next) },
        column.title, avs.h("span.arrow", { "aria-hidden": "true" }, { up: "▲", down: "▼" }[direction] || ""))
      : column.title;
    return avs.h(column.text ? "th.name" : column.quiet ? "th.quiet" : "th", { scope: "col", "aria-sort": { up: "ascending", down: "descending" }[direction] || null }, inside);
  }

  // The better end comes first, then the other, then the table's own order.
  function nextDirection(column, direction) {
    const first = column.text || column.higher === false ? "up" : "down";
    if (!direction) return first;
    return direction === first ? { up: "down", down: "up" }[first] : null;
  }

  function sortedBlocks(told, grouped, options) {
    const rows = grouped.flatMap((group) => group.rows.map((row) => ({ ...row, group: group.name, metric: group.metric })));
    const [place, kind] = options.sort.split(".");
    const value = (row) => (options.sort === "label" ? row.label.toLowerCase() : cellValue(row.cells[Number(place)], kind));
    const known = rows.filter((row) => value(row) !== null);
    const unknown = rows.filter((row) => value(row) === null);
    const sign = options.direction === "down" ? -1 : 1;
    known.sort((one, other) => sign * (value(one) < value(other) ? -1 : value(one) > value(other) ? 1 : 0));
    return [{ name: "", metric: null, rows: [...known, ...unknown], mixed: true }];
  }

  function cellValue(cell, kind) {
    if (!cell) return null;
    if (kind === "published") return cell.published === null ? null : Number(cell.published);
    if (kind === "difference") return difference(cell);
    if (cell.value !== null) return cell.value;
    return cell.text === null || Number.isNaN(Number(cell.text)) ? null : Number(cell.text);
  }

  function difference(cell) {
    return cell.value === null || cell.published === null ? null : cell.value - Number(cell.published);
  }

  function tableRow(told, group, row, place, hasGroups, options) {
    const heading = group.mixed ? groupTitle({ name: row.group, metric: row.metric }) : place === 0 ? groupTitle(group) : "";
    return avs.h(row.proposed ? "tr.proposed" : "tr", {},
      hasGroups ? avs.h("td.group", {}, heading) : null,
      avs.h("th.name", { scope: "row" }, rowName(row, options)),
      told.columns.flatMap((column, index) => cells(told, group, row, column, row.cells[index], index, options)));
  }

  function rowName(row, options) {
    const method = row.identifier && options.colour ? options.colour(row.identifier) : null;
    return [method ? avs.h("span.dot", { style: `background:${method}`, "aria-hidden": "true" }) : null, row.label];
  }

  function groupTitle(group) {
    return [group.name, group.metric ? group.metric.name : ""].filter(Boolean).join(" ");
  }

  function cells(told, group, row, column, cell, index, options) {
    const metric = group.metric || row.metric || column.metric;
    const found = [valueCell(cell, metric, options.link ? options.link(row, index) : null)];
    if (column.published) found.push(avs.h("td.quiet", {}, cell.published === null ? avs.DASH : cell.published));
    if (column.difference) found.push(avs.h("td.quiet", {}, avs.signed(difference(cell), metric.decimals)));
    return found;
  }

  function valueCell(cell, metric, link) {
    if (cell.text !== null) return avs.h("td", {}, cell.text);
    if (cell.value === null) return avs.h(cell.cause ? "td.cause" : "td", {}, cell.cause || avs.DASH);
    const spread = cell.spread === null ? null : avs.h("span.spread", {}, ` ± ${avs.fixed(cell.spread, metric.decimals)}`);
    const text = [avs.fixed(cell.value, metric.decimals), spread];
    return avs.h(cell.rank ? `td.rank${cell.rank}` : "td", { title: cell.rank ? MARKS[cell.rank] : null },
      link ? avs.h("a", { href: link }, text) : text);
  }

  function legend(told) {
    const ranked = told.groups.some((group) => group.rows.some((row) => row.cells.some((cell) => cell.rank)));
    if (!ranked) return null;
    return avs.h("p.quiet.legend", {}, [1, 2, 3].map((rank) => [avs.h(`span.rank${rank}`, {}, MARKS[rank]), " "]), "of the printed means, whatever their intervals.");
  }

  function comparison(told) {
    if (!told.comparison) return null;
    const metrics = told.columns.map((column) => column.metric);
    return avs.h("details", { open: told.openComparison ?? true }, avs.h("summary", {}, told.comparison.title),
      avs.h("div.scroll", { tabindex: "0", role: "region", "aria-label": "differences, scrolls sideways" }, avs.h("table.numbers", {},
        avs.h("thead", {}, avs.h("tr", {}, avs.h("th.name", { scope: "col" }, told.rows_are),
          metrics.map((metric) => avs.h("th", { scope: "col" }, metric.name + (metric.unit ? ` (${metric.unit})` : ""))), avs.h("th.forest", { scope: "col" }, `${metrics[0].name}, about 0`))),
        avs.h("tbody", {}, told.comparison.rows.map(([label, found]) => avs.h("tr", {}, avs.h("th.name", { scope: "row" }, label),
          metrics.map((metric, place) => avs.h("td", {}, differenceText(found[place], metric.decimals))),
          avs.h("td.forest", {}, forest(found[0], reach(told.comparison)))))))));
  }

  function differenceText(found, decimals) {
    if (!found) return avs.DASH;
    const interval = found.interval ? ` [${avs.signed(found.interval[0], decimals)}, ${avs.signed(found.interval[1], decimals)}]` : "";
    return `${avs.signed(found.value, decimals)}${interval}`;
  }

  function reach(told) {
    const ends = told.rows.flatMap(([, found]) => (found[0] ? [found[0].value, ...(found[0].interval || [])] : []));
    return Math.max(...ends.map(Math.abs), 1e-9);
  }

  function forest(found, most) {
    if (!found) return null;
    const at = (value) => 60 + (value / most) * 56;
    const ends = found.interval || [found.value, found.value];
    const excludes = ends[0] > 0 || ends[1] < 0;
    return avs.svg("svg", { viewBox: "0 0 120 14", class: excludes ? "forest told" : "forest", "aria-hidden": "true" },
      avs.svg("line", { x1: 60, x2: 60, y1: 0, y2: 14, class: "zero" }),
      avs.svg("line", { x1: at(ends[0]), x2: at(ends[1]), y1: 7, y2: 7 }),
      avs.svg("circle", { cx: at(found.value), cy: 7, r: 2.6 }));
  }

  function notes(told) {
    if (!told.notes.length) return null;
    return avs.h("details.notes", { open: told.notes.length < 8 }, avs.h("summary", {}, `Notes (${told.notes.length})`),
      avs.h("ul", {}, told.notes.map((note) => avs.h("li", {}, note))));
  }
})();
