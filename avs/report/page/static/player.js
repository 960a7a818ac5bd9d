// The slider over the moments of a replay, with buttons and the arrow keys of the page.
"use strict";

(() => {
  const MILLISECONDS = 900;

  // `last` is the greatest moment; `text(moment)` says what it is; `onmove(moment)` draws it.
  avs.player = (last, moment, text, onmove) => {
    let timer = null;
    const slider = avs.h("input", { type: "range", min: 0, max: last, value: moment, "aria-label": "moment of the replay", oninput: () => move(Number(slider.value)) });
    const words = avs.h("output", { "aria-live": "polite" });
    const play = avs.h("button", { type: "button", "aria-pressed": "false", onclick: toggle }, "play");
    const button = (label, sign, step) => avs.h("button", { type: "button", "aria-label": label, onclick: () => move(Number(slider.value) + step) }, sign);
    function move(next) {
      const bounded = Math.min(Math.max(next, 0), last);
      slider.value = bounded;
      describe(bounded);
      onmove(bounded);
    }
    function describe(at) {
      words.textContent = text(at);
      slider.setAttribute("aria-valuetext", text(at));
    }
    function toggle() {
      if (timer) stop();
      else {
        if (Number(slider.value) === last) move(0);
        timer = setInterval(() => {
          if (!element.isConnected || Number(slider.value) >= last) stop();
          else move(Number(slider.value) + 1);
        }, MILLISECONDS);
        play.textContent = "pause";
      }
      play.setAttribute("aria-pressed", String(Boolean(timer)));
    }
    function stop() {
      clearInterval(timer);
      timer = null;
      play.textContent = "play";
      play.setAttribute("aria-pressed", "false");
    }
    const element = avs.h("div.player", {}, button("one moment back", "◀", -1), play, button("one moment on", "▶", 1), slider, words);
    describe(moment);
    avs.onkey = (event) => {
      if (!element.isConnected) return;
      if (event.key === "ArrowLeft") move(Number(slider.value) - 1);
      if (event.key === "ArrowRight") move(Number(slider.value) + 1);
    };
    return { element, move };
  };
})();
