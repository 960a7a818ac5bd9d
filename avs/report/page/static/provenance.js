// Where an episode's numbers come from: code, machine, settings, hashes; and trees of settings anywhere.
"use strict";

(() => {
  avs.tree = (value) => {
    if (value === null || typeof value !== "object") return avs.h("code", {}, value === null ? "null" : String(value));
    const entries = Object.entries(value);
    if (!entries.length) return avs.h("code", {}, Array.isArray(value) ? "[]" : "{}");
    if (Array.isArray(value) && value.every((each) => each === null || typeof each !== "object")) return avs.h("code", {}, value.join(", "));
    return avs.h("dl.tree", {}, entries.map(([key, each]) => avs.h("div", {}, avs.h("dt", {}, key), avs.h("dd", {}, avs.tree(each)))));
  };

  avs.provenance = ({ episode, scene }) => {
    const told = episode.provenance;
    const facts = {
      "git revision": told.revision || "not known", started: told.started, finished: told.finished, device: told.device,
      "total time": avs.seconds(told.total_seconds), "peak memory": avs.megabytes(told.peak_memory_bytes),
      "SHA-256 of episode.json": told.record_sha256, "content hash of the scene": told.scene_hash,
      "SHA-256 of the pictures": told.pictures_sha256 || "none kept",
      weights: told.weights_sha256 ? `${told.weights || "file"}, ${told.weights_sha256}` : "none",
      "source of the pictures": scene.source, licence: scene.licence,
    };
    return avs.h("details.panel", {}, avs.h("summary", {}, "Provenance and settings"),
      avs.tree(facts), scene.notes.length ? [avs.h("h3", {}, "Notes on the scene"), avs.h("ul", {}, scene.notes.map((note) => avs.h("li", {}, note)))] : null,
      avs.h("h3", {}, "Machine"), avs.tree(told.machine), avs.h("h3", {}, "Packages"), avs.tree(told.packages),
      Object.entries(episode.settings).map(([name, settings]) => [avs.h("h3", {}, `Settings: ${name}`), avs.tree(settings)]));
  };
})();
