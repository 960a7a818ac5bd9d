// Filters of a table of episodes: groups and methods leave rows out; scenes and seeds make new means of single values.
"use strict";

(() => {
  const ENOUGH_FOR_SPREAD = 3;

  // The values of single scenes as objects, or nothing where a table has none.
  avs.singles = (told) => {
    if (!told.per_scene) return [];
    const { fields, records } = told.per_scene;
    const singles = records.map((record) => Object.fromEntries(fields.map((field, place) => [field, record[place]])));
    // Two data sets may each have a scene of one name.
    const several = new Set(singles.map((each) => each.dataset)).size > 1;
    return singles.map((each) => ({
      ...each,
      method: each.method ?? each.predictor,
      scene: several ? `${each.dataset}/${each.scene}` : each.scene,
    }));
  };

  // Returns the document with the rows and means that are asked for.
  avs.filtered = (told, { scene, seed, group, method }) => {
    let shown = told;
    if (scene || seed) shown = recomputed(shown, scene, seed);
    const words = (method || "").toLowerCase().split(/[\s,]+/).filter(Boolean);
    const kept = (row) => !words.length || words.some((word) => row.label.toLowerCase().includes(word) || row.identifier === word);
    const groups = shown.groups
      .filter((each) => !group || each.name === group)
      .map((each) => ({ ...each, rows: each.rows.filter(kept) }))
      .filter((each) => each.rows.length);
    const labels = new Set(groups.flatMap((each) => each.rows.map((row) => row.label)));
    const comparison = shown.comparison && { ...shown.comparison, rows: shown.comparison.rows.filter(([label]) => labels.has(label)) };
    return { ...shown, groups, comparison: comparison && comparison.rows.length ? comparison : null };
  };

  function recomputed(told, scene, seed) {
    const singles = avs.singles(told).filter((each) => (!scene || each.scene === scene) && (!seed || String(each.seed) === seed));
    const scenes = [...new Set(singles.map((each) => each.scene))];
    const single = new Set(singles.map((each) => each.metric));
    const known = told.columns.filter((column) => single.has(column.metric.identifier));
    const places = known.map((column) => told.columns.indexOf(column));
    const columns = known.map((column) => ({ ...column, published: null, difference: false }));
    const groups = told.groups.map((group) => ({
      ...group,
      rows: group.rows.map((row) => ({ ...row, cells: columns.map((column, place) => meanCell(singles, row, column.metric, scenes, row.cells[places[place]])) })),
    }));
    const hasSeeds = told.per_scene.fields.includes("seed");
    const counted = scenes.length === 1 ? "1 scene" : `${scenes.length} scenes`;
    const what = [scene ? `scene ${scene}` : counted, seed ? `seed ${seed}` : hasSeeds ? "all seeds" : null].filter(Boolean).join(", ");
    const paper = told.columns.some((column) => column.published) ? ["The paper's means are over other scenes and are left out."] : [];
    return {
      ...told,
      columns,
      groups: ranked(told, columns, groups),
      comparison: null,
      caption: [`${what}: means of the single values of this table, computed by the page.`, ...paper],
    };
  }

  // As the tables do it: a seed counts with all scenes; the mean is over scenes, then over seeds.
  function meanCell(singles, row, metric, scenes, whole) {
    const own = singles.filter((each) => each.method === row.identifier && each.metric === metric.identifier && each.value !== null);
    const seeds = [...new Set(own.map((each) => each.seed))];
    const means = seeds
      .map((seed) => own.filter((each) => each.seed === seed))
      .filter((each) => each.length === scenes.length)
      .map((each) => avs.mean(each.map((single) => single.value)));
    const missing = row.cells.find((cell) => cell.cause);
    const empty = { value: null, spread: null, rank: null, published: null, cause: null, text: null, ranked: whole?.ranked ?? true };
    if (!means.length) return { ...empty, cause: missing ? missing.cause : null };
    return { ...empty, value: avs.mean(means), spread: spread(means) };
  }

  function spread(means) {
    if (means.length < ENOUGH_FOR_SPREAD) return null;
    const middle = avs.mean(means);
    return Math.sqrt(means.reduce((sum, value) => sum + (value - middle) ** 2, 0) / (means.length - 1));
  }

  // Ranks among the rows that compete in the table itself; a table without ranks stays without.
  function ranked(told, columns, groups) {
    if (!told.groups.some((group) => group.rows.some((row) => row.cells.some((cell) => cell.rank)))) return groups;
    const places = columns.map(({ metric }, place) => {
      if (metric.higher_is_better === null) return [];
      const values = groups.flatMap((group) => group.rows).filter((row) => row.ranked)
        .map((row) => row.cells[place]).filter((cell) => cell.ranked).map((cell) => cell.value).filter((value) => value !== null)
        .map((value) => Number(avs.printed(value, metric.decimals)));
      const best = [...new Set(values)].sort((one, other) => (metric.higher_is_better ? other - one : one - other));
      return best.slice(0, 3);
    });
    return groups.map((group) => ({
      ...group,
      rows: group.rows.map((row) => (row.ranked
        ? { ...row, cells: row.cells.map((cell, place) => ({ ...cell, rank: rankOf(cell, columns[place].metric, places[place]) })) }
        : row)),
    }));
  }

  function rankOf(cell, metric, best) {
    const place = cell.value === null || !cell.ranked ? -1 : best.indexOf(Number(avs.printed(cell.value, metric.decimals)));
    return place < 0 ? null : place + 1;
  }
})();
