// Two pictures of one view over each other, with a divider that is a slider: what is left of it shows the first.
"use strict";

(() => {
  const MOST_HEIGHT = 480;

  // `left` and `right` are {picture, label}; a picture that is null is shown as missing with `why`.
  avs.imageSlider = (left, right, { label, share = 50, onshare = null, why }) => {
    if (!left.picture && !right.picture) return avs.missing(why);
    if (!left.picture || !right.picture) {
      const one = left.picture ? left : right;
      const other = left.picture ? right : left;
      return avs.h("figure.pair", {}, avs.h("img", { src: one.picture, alt: `${one.label}: ${label}` }), avs.h("figcaption", {}, `${one.label}. ${other.label}: ${why}`));
    }
    const over = avs.h("img.over", { src: left.picture, alt: `${left.label}: ${label}` });
    const line = avs.h("span.divider", { "aria-hidden": "true" });
    const slider = avs.h("input", { type: "range", min: 0, max: 100, value: share, "aria-label": `divider between ${left.label} and ${right.label}: ${label}` });
    const place = () => {
      over.style.clipPath = `inset(0 ${100 - slider.value}% 0 0)`;
      line.style.left = `${slider.value}%`;
      if (onshare) onshare(slider.value);
    };
    slider.addEventListener("input", place);
    slider.addEventListener("keydown", (event) => event.stopPropagation());
    const under = avs.h("img", { src: right.picture, alt: `${right.label}: ${label}` });
    const element = avs.h("figure.pair", {},
      avs.h("div.stack", {}, under, over, line, slider),
      avs.h("figcaption", {}, avs.h("span", {}, left.label), avs.h("span", {}, right.label)));
    // An upright picture of the full width would be higher than a screen.
    under.addEventListener("load", () => {
      const share = under.naturalWidth / under.naturalHeight;
      if (share < 1) element.style.maxWidth = `${Math.round(MOST_HEIGHT * share)}px`;
    });
    place();
    return element;
  };
})();
