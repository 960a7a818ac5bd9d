// The parts of an episode that its own view and the comparison show: what was captured, seen and scored at each selection.
"use strict";

(() => {
  avs.place = (dataset, scene) => `scenes/${dataset}/${scene}`;

  // Loads an episode with what belongs to its scene.
  avs.loadEpisode = async (dataset, scene, method, seed) => {
    const place = avs.place(dataset, scene);
    const [told, photographs, episode] = await Promise.all([
      avs.load(`${place}/scene`), avs.load(`${place}/photographs`), avs.load(`${place}/${method}-${seed}`)]);
    fillCandidates(episode);
    const pictures = episode.no_pictures ? {} : await avs.load(`${place}/${method}-${seed}-pictures`);
    return { place, scene: told, photographs, episode, pictures };
  };

  // Candidates are listed where they are not those of the selection before without the views that it chose.
  function fillCandidates({ steps }) {
    for (const [place, step] of steps.entries()) {
      step.candidates = step.candidates || steps[place - 1].candidates.filter((camera) => !steps[place - 1].chosen.includes(camera));
    }
  }

  // The moments of an episode: each selection, then the end.
  avs.moments = (episode) => episode.steps.length + 1;

  // What had been captured before a selection; at the end all of it, in the order of capture.
  avs.capturedBefore = (episode, moment) =>
    [...episode.initial, ...episode.steps.slice(0, moment).flatMap((step) => step.chosen)].slice(0, episode.initial.length + episode.selected.length);

  // What was measured on the test images with so many views, before a selection or between two; the last with all of them.
  avs.pointAt = ({ curve }, views) => curve.findLast((each) => each.views === views);

  avs.methodOf = (scene, identifier) => scene.methods.find((method) => method.id === identifier);

  // Says in one line where the replay is.
  avs.momentText = ({ episode, scene }, moment) => {
    const views = avs.capturedBefore(episode, moment).length;
    const step = episode.steps[moment];
    if (!step) return `End: ${views} views, iteration ${episode.curve.at(-1).iteration.toLocaleString("en")}`;
    const chosen = step.chosen.map((camera) => scene.names[camera]).join(", ");
    return `Selection ${moment + 1} of ${episode.steps.length}: ${views} views, iteration ${step.iteration.toLocaleString("en")}, chosen ${chosen}`;
  };

  // The rendering of the chosen view beside its photograph, and the score maps; at the end a test image.
  avs.viewPart = (loaded, moment, state, redraw) => {
    const { episode } = loaded;
    return episode.steps[moment] ? chosenPart(loaded, moment, state, redraw) : testPart(loaded, state, redraw);
  };

  function photograph({ photographs }, camera) {
    return photographs.pictures[String(camera)] || null;
  }

  function chosenPart(loaded, moment, state, redraw) {
    const { episode, scene, pictures } = loaded;
    const { chosen } = episode.steps[moment];
    const which = Math.min(state.which || 0, chosen.length - 1);
    const name = `choice_${String(moment).padStart(2, "0")}_${which}`;
    const why = episode.no_pictures || (pictures[`${name}_rendering`] ? loaded.photographs.why_not : "the run kept no pictures of choices");
    const title = scene.names[chosen[which]];
    return [
      chosen.length > 1 ? avs.select("View", chosen.map((camera, place) => [String(place), scene.names[camera]]), String(which), (value) => redraw({ which: Number(value) })) : null,
      avs.imageSlider(
        { picture: pictures[`${name}_rendering`], label: "Rendering when it was chosen" },
        { picture: photograph(loaded, chosen[which]), label: "Photograph" },
        { label: title, share: state.share, onshare: (share) => { state.share = share; }, why }),
      maps(pictures, name),
    ];
  }

  function maps(pictures, name) {
    const found = [["predicted", "predicted SSIM"], ["true", "true SSIM"]].filter(([key]) => pictures[`${name}_${key}`]);
    if (!found.length) return null;
    return avs.h("div.maps", {}, found.map(([key, words]) => avs.h("figure", {}, avs.h("img", { src: pictures[`${name}_${key}`], alt: `map of ${words}` }), avs.h("figcaption", {}, `${words}, black 0 to white 1`))));
  }

  function testPart(loaded, state, redraw) {
    const { episode, scene, pictures } = loaded;
    if (!episode.kept.length) return avs.missing(`No rendering of a test image: ${episode.no_pictures || "the run keeps none"}.`);
    const place = Math.min(state.test || 0, episode.kept.length - 1);
    const camera = episode.kept[place];
    const last = episode.curve.at(-1);
    const row = episode.test.indexOf(camera);
    const values = Object.entries(avs.METRICS).filter(([metric]) => last[metric][row] !== null).map(([metric, told]) => `${told.name} ${avs.fixed(last[metric][row], told.decimals)}${told.unit ? ` ${told.unit}` : ""}`);
    return [
      avs.select("Test image", episode.kept.map((each, index) => [String(index), scene.names[each]]), String(place), (value) => redraw({ test: Number(value) })),
      avs.imageSlider(
        { picture: pictures[`final_${String(place).padStart(3, "0")}`], label: "Final rendering" },
        { picture: photograph(loaded, camera), label: "Photograph" },
        { label: scene.names[camera], share: state.share, onshare: (share) => { state.share = share; }, why: episode.no_pictures || loaded.photographs.why_not }),
      avs.h("p.quiet", {}, values.join(" · ")),
    ];
  }

  avs.scorePart = ({ episode, scene }, moment, byScore) => {
    const step = episode.steps[moment];
    if (!step) return avs.h("p.quiet", {}, "All views are captured; the optimisation went on to its end.");
    return avs.scoreBars(step, { chooses: episode.chooses, names: scene.names, byScore, measures: episode.measures });
  };

  // Roles of all cameras at a moment, for the view in space.
  avs.roles = ({ episode, scene }, moment) => {
    const roles = scene.names.map(() => "candidate");
    for (const camera of scene.test) roles[camera] = "test";
    const captured = avs.capturedBefore(episode, moment);
    const order = new Map();
    for (const [place, camera] of captured.entries()) {
      roles[camera] = place < episode.initial.length ? "initial" : "captured";
      if (place >= episode.initial.length) order.set(camera, place - episode.initial.length + 1);
    }
    for (const [place, camera] of (episode.steps[moment]?.chosen || []).entries()) {
      roles[camera] = "chosen";
      order.set(camera, captured.length - episode.initial.length + place + 1);
    }
    return [roles, order];
  };

  // Photographs in the order of capture.
  avs.stripPart = (loaded, moment) => {
    const { episode, scene } = loaded;
    const captured = avs.capturedBefore(episode, moment);
    const next = episode.steps[moment]?.chosen || [];
    const item = (camera, kind) => {
      const picture = photograph(loaded, camera);
      return avs.h(`li.${kind}`, {}, picture ? avs.h("img", { src: picture, alt: "" }) : avs.h("span.empty", { title: loaded.photographs.why_not }, "left out"), avs.h("span", {}, scene.names[camera]));
    };
    const strip = avs.h("ol.strip", { tabindex: "0", "aria-label": `${captured.length} captured photographs in the order of capture` },
      captured.map((camera, place) => item(camera, place < episode.initial.length ? "initial" : "captured")), next.map((camera) => item(camera, "chosen")));
    requestAnimationFrame(() => { strip.scrollLeft = strip.scrollWidth; }); // the newest are the last
    return strip;
  };

  // The test curves of one seed of a scene; `strong` are the methods that are brought out.
  avs.curvePart = (scene, seed, strong, metric, mark, colours = null) => {
    const place = { psnr: 3, ssim: 4, lpips: 5 }[metric];
    const lines = Object.values(scene.episodes).filter((each) => each.seed === seed).map((each) => {
      const method = avs.methodOf(scene, each.method);
      return { label: method.label, colour: colours ? colours[each.method] ?? "#b8b8b8" : method.colour, strong: strong.includes(each.method), dashed: !method.ranked, points: each.curve.map((point) => [point[0], point[place]]) };
    });
    const told = avs.METRICS[metric];
    return avs.lineChart(lines, { x: "captured views", y: `${told.name}${told.unit ? ` (${told.unit})` : ""} of the test images`, mark, label: `${told.name} over the number of views; bold: ${strong.join(", ")}` });
  };

  // A text with a button that copies it.
  avs.copyText = (label, text, rows = 6) => {
    const area = avs.h("textarea", { readonly: true, rows, "aria-label": label, spellcheck: "false" }, text);
    const button = avs.h("button", { type: "button", onclick: async () => {
      area.select();
      try {
        await navigator.clipboard.writeText(text);
      } catch {
        document.execCommand("copy"); // pages from disk may not use the other
      }
      button.textContent = "copied";
    } }, "copy");
    return avs.h("div.copy", {}, area, button);
  };
})();
