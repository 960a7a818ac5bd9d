// The scores of all candidates of one selection as bars, in the order of their scores or of their names.
"use strict";

(() => {
  const HEIGHT = 150;

  // Draws {candidates, scores, chosen}; `chooses` is lowest or highest; `names` are those of the scene's images.
  avs.scoreBars = ({ candidates, scores, chosen }, { chooses, names, byScore, measures, onpick = null }) => {
    if (!scores) return avs.missing("This method has no scores: its views were given.");
    const known = candidates.map((camera, place) => ({ camera, score: scores[place] })).filter((each) => each.score !== null);
    const left = candidates.length - known.length;
    if (!known.length) return avs.missing("No candidate has a score.");
    if (byScore) known.sort((one, other) => (chooses === "lowest" ? one.score - other.score : other.score - one.score));
    const values = known.map((each) => each.score);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    if (low === high) {
      return avs.h("p.quiet", {}, `All ${known.length} candidates have the score ${avs.short(low)}; the choice was ${chosen.map((camera) => names[camera]).join(", ")}.`);
    }
    const margin = (high - low) * 0.05;
    const [bottom, top] = low >= 0 && low < 0.4 * high ? [0, high + margin] : [low - margin * 3, high + margin];
    const width = 100 / known.length;
    const bar = ({ camera, score }, place) => {
      const tall = ((score - bottom) / (top - bottom)) * HEIGHT;
      const picked = chosen.indexOf(camera);
      return avs.svg("rect", {
        x: `${place * width + width * 0.1}%`, width: `${width * 0.8}%`, y: HEIGHT - tall, height: Math.max(tall, 1),
        class: picked >= 0 ? "bar chosen" : "bar", onclick: onpick ? () => onpick(camera) : null,
      }, avs.svg("title", {}, `${names[camera]}: ${avs.short(score)}${picked >= 0 ? ", chosen" : ""}`));
    };
    const told = `Scores of ${known.length} candidates from ${avs.short(low)} to ${avs.short(high)}; chosen: ${chosen.map((camera) => names[camera]).join(", ")}`;
    return avs.h("figure.bars", {},
      avs.svg("svg", { role: "img", "aria-label": told, height: HEIGHT }, known.map(bar)),
      avs.h("figcaption", {},
        avs.h("span", {}, byScore ? (chooses === "lowest" ? "lowest first: it is taken" : "highest first: it is taken") : "in the order of names"),
        ` · from ${avs.short(low)} to ${avs.short(high)}${bottom !== 0 ? ", bars do not start at zero" : ""}`,
        measures ? ` · the score is ${measures === "gain" ? "the gain measured by a short fit" : `the true ${measures.toUpperCase()}`}` : "",
        left ? ` · ${left} candidates were not scored` : ""));
  };
})();
