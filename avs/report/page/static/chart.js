// A line chart as SVG, with a legend of buttons that bring out one line.
"use strict";

(() => {
  const WIDTH = 560;
  const HEIGHT = 240;
  const LEFT = 46;
  const BOTTOM = 34;
  const TOP = 10;
  const RIGHT = 10;

  // Draws lines {points: [[x, y]], colour, strong, dashed, label}; `mark` is an x that is set off.
  avs.lineChart = (lines, { x, y, mark = null, label }) => {
    const drawn = lines.map((line) => ({ ...line, points: line.points.filter((point) => point[1] !== null) }));
    const points = drawn.flatMap((line) => line.points);
    if (!points.length) return avs.missing(`${y}: not measured`);
    const [lowX, highX] = range(points.map((point) => point[0]));
    const [lowY, highY] = padded(range(points.map((point) => point[1])));
    const toX = (value) => LEFT + ((value - lowX) / (highX - lowX || 1)) * (WIDTH - LEFT - RIGHT);
    const toY = (value) => HEIGHT - BOTTOM - ((value - lowY) / (highY - lowY || 1)) * (HEIGHT - BOTTOM - TOP);
    const picture = avs.svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label, class: "chart" });
    for (const value of avs.ticks(lowY, highY, 5)) {
      picture.append(
        avs.svg("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: toY(value), y2: toY(value), class: "grid" }),
        avs.svg("text", { x: LEFT - 6, y: toY(value) + 4, "text-anchor": "end" }, avs.short(value)),
      );
    }
    for (const value of avs.ticks(lowX, highX, 8, points.every((point) => Number.isInteger(point[0])) ? 1 : 0)) {
      picture.append(avs.svg("text", { x: toX(value), y: HEIGHT - BOTTOM + 16, "text-anchor": "middle" }, avs.short(value)));
    }
    picture.append(
      avs.svg("text", { x: WIDTH - RIGHT, y: HEIGHT - 3, "text-anchor": "end", class: "axis" }, x),
      avs.svg("text", { x: LEFT + 4, y: TOP + 9, class: "axis" }, y),
    );
    if (mark !== null) {
      picture.append(avs.svg("line", { x1: toX(mark), x2: toX(mark), y1: TOP, y2: HEIGHT - BOTTOM, class: "mark" }));
    }
    for (const line of [...drawn].sort((one, other) => Number(one.strong || 0) - Number(other.strong || 0))) {
      const path = line.points.map((point, place) => `${place ? "L" : "M"}${toX(point[0]).toFixed(1)} ${toY(point[1]).toFixed(1)}`);
      picture.append(
        avs.svg(
          "path",
          {
            d: path.join(""),
            stroke: line.colour,
            class: line.strong ? "line strong" : "line",
            "stroke-dasharray": line.dashed ? "5 3" : null,
          },
          avs.svg("title", {}, `${line.label}: ${avs.short(line.points.at(-1)?.[1] ?? null)} at the end`),
        ),
      );
    }
    return picture;
  };

  function range(values) {
    return [Math.min(...values), Math.max(...values)];
  }

  function padded([low, high]) {
    const margin = (high - low || Math.abs(high) || 1) * 0.06;
    return [low - margin, high + margin];
  }

  // Round numbers between two ends, at most `most` of them, and no nearer to one another than `least`.
  avs.ticks = (low, high, most, least = 0) => {
    const rough = Math.max((high - low || 1) / most, least);
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => each >= rough * 0.999);
    const found = [];
    for (let place = Math.ceil(low / step - 1e-9); place * step <= high + step * 1e-9; place += 1) found.push(place * step);
    return found.map((value) => Number(value.toPrecision(12)));
  };
})();
