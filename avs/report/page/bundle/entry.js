// What of the viewer the page uses, as window.avsSplats.
export { Viewer, SceneFormat } from "@mkkellogg/gaussian-splats-3d";
