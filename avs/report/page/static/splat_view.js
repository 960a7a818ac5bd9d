// The final model of an episode, drawn by the bundled viewer of 3D Gaussians, which is loaded only when one is opened.
"use strict";

(() => {
  const SPLAT = 0; // the viewer's number of the layout of 32 bytes a Gaussian

  avs.splatPart = ({ place, scene, episode }) => {
    if (episode.no_splats) return avs.missing(`The model: ${episode.no_splats}.`);
    const area = avs.h("div.model");
    const open = () => area.replaceChildren(avs.later(shown(place, scene, episode), (element) => element, "loading the model"));
    area.append(avs.h("button", { type: "button", onclick: open }, "show the model"));
    return [area, avs.h("p.quiet", {}, "Gaussians in their mean colour, without what depends on the direction. splats.ply in the folder of the episode has all of it and opens in any viewer of 3D Gaussians.")];
  };

  async function shown(place, scene, episode) {
    if (!hasGraphics()) throw new Error("This browser has no WebGL 2, which the viewer of models needs; splats.ply opens in other programs. (cannot be loaded)");
    const [told] = await Promise.all([avs.load(`${place}/${episode.method}-${episode.seed}-splats`), avs.script("static/splats.bundle.js")]);
    const content = avs.bytes(told.splats);
    const element = avs.h("div.splats", { tabindex: "0", role: "img", "aria-label": "the final model; drag to turn, wheel to zoom" });
    const caption = avs.h("p.quiet", {}, `${(content.length / 32).toLocaleString("en")} of ${told.count.toLocaleString("en")} Gaussians; seen from the first test view.`);
    requestAnimationFrame(() => begin(element, content, scene).catch((error) => element.replaceChildren(avs.missing(`The viewer has failed: ${error.message}`))));
    return [element, caption];
  }

  function hasGraphics() {
    return Boolean(document.createElement("canvas").getContext("webgl2"));
  }

  async function begin(element, content, scene) {
    const view = camera(scene);
    const viewer = new window.avsSplats.Viewer({
      rootElement: element, cameraUp: view.up, initialCameraPosition: view.from, initialCameraLookAt: view.at,
      sharedMemoryForWorkers: false, gpuAcceleratedSort: false, selfDrivenMode: true, useBuiltInControls: true, sphericalHarmonicsDegree: 0,
    });
    const address = URL.createObjectURL(new Blob([content]));
    await viewer.addSplatScene(address, { format: SPLAT, showLoadingUI: false, progressiveLoad: false, splatAlphaRemovalThreshold: 1 });
    URL.revokeObjectURL(address);
    viewer.start();
    element.dataset.ready = "true";
    const watch = setInterval(() => {
      if (element.isConnected) return;
      clearInterval(watch);
      viewer.dispose();
    }, 1000);
  }

  // The first test view, or the first of all: where it stands, a point that it looks at, and what is up there.
  function camera({ cameras, test }) {
    const place = test.length ? test[0] : 0;
    const row = cameras.outlines.slice(place * 15, place * 15 + 15);
    const from = row.slice(0, 3);
    const ahead = [0, 1, 2].map((axis) => avs.mean([3, 6, 9, 12].map((corner) => row[corner + axis])) - from[axis]);
    const size = Math.hypot(...from) / (Math.hypot(...ahead) || 1) || 1;
    return { from, at: from.map((value, axis) => value + ahead[axis] * size), up: cameras.down.slice(place * 3, place * 3 + 3).map((value) => -value) };
  }
})();
