// Cameras and points in space, seen without perspective; turned by dragging or the arrow keys, nearer with + and the wheel.
"use strict";

(() => {
  const ROLES = {
    candidate: { colour: "#a9b0b8", width: 1, about: "candidate" },
    test: { colour: "#b58bd6", width: 1, about: "test view", dashed: true },
    initial: { colour: "#20262c", width: 1.4, about: "initial view" },
    captured: { colour: "#0b5cad", width: 1.4, about: "selected before" },
    chosen: { colour: "#d5480b", width: 2.4, about: "selected now" },
  };
  const TURN = 0.12;

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const scaled = (a, factor) => a.map((value) => value * factor);
  const unit = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));

  // Rotates a vector about an axis of length 1.
  function rotated(vector, axis, angle) {
    const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
    const side = cross(axis, vector);
    const along = dot(axis, vector) * (1 - cosine);
    return vector.map((value, place) => value * cosine + side[place] * sine + axis[place] * along);
  }

  // Makes a view of a scene. `points`: {xyz, colours as bytes}; returns its element and `update(roles, order)`.
  avs.sceneSpace = (cameras, points, { label, height = 300 }) => {
    const canvas = avs.h("canvas.space", { tabindex: "0", role: "img", "aria-label": `${label}; arrow keys turn it, plus and minus zoom, 0 resets` });
    canvas.style.height = `${height}px`;
    const count = cameras.outlines.length / 15;
    const corner = (camera, place) => cameras.outlines.slice(camera * 15 + place * 3, camera * 15 + place * 3 + 3);
    const centres = [...Array(count).keys()].map((camera) => corner(camera, 0));
    const middle = [0, 1, 2].map((axis) => avs.mean(centres.map((centre) => centre[axis])));
    const radius = Math.max(...centres.map((centre) => Math.hypot(...centre.map((value, axis) => value - middle[axis])))) || 1;
    const upward = unit([0, 1, 2].map((axis) => -avs.mean(centres.map((_, camera) => cameras.down[camera * 3 + axis]))));
    const start = () => ({ right: cameras.right, up: cameras.up, forward: cameras.forward, zoom: 1 });
    let eye = start();
    let shown = { roles: [], order: new Map() };

    function turn(sideways, upwards) {
      for (const key of ["right", "up", "forward"]) eye[key] = rotated(eye[key], upward, sideways);
      const axis = unit(eye.right);
      const tilted = rotated(eye.forward, axis, upwards);
      if (Math.abs(dot(tilted, upward)) < 0.999) for (const key of ["up", "forward"]) eye[key] = rotated(eye[key], axis, upwards);
      draw();
    }
    function zoom(factor) {
      eye.zoom = Math.min(40, Math.max(0.2, eye.zoom * factor));
      draw();
    }

    function draw() {
      const [width, tall] = [canvas.clientWidth, canvas.clientHeight];
      if (!width) return;
      const ratio = window.devicePixelRatio || 1;
      if (canvas.width !== Math.round(width * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(tall * ratio)];
      const context = canvas.getContext("2d");
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, tall);
      const unitPixels = (Math.min(width, tall) / 2 / (radius * 1.25)) * eye.zoom;
      const flat = (place) => {
        const moved = place.map((value, axis) => value - middle[axis]);
        return [width / 2 + dot(moved, eye.right) * unitPixels, tall / 2 - dot(moved, eye.up) * unitPixels];
      };
      drawPoints(context, flat);
      const rank = Object.keys(ROLES);
      const order = shown.roles.map((role, camera) => [role, camera]).filter(([role]) => role).sort((one, other) => rank.indexOf(one[0]) - rank.indexOf(other[0]));
      for (const [role, camera] of order) drawCamera(context, flat, camera, ROLES[role]);
    }

    function drawPoints(context, flat) {
      if (!points) return;
      const size = points.size || 1.6;
      for (let place = 0; place < points.xyz.length / 3; place += 1) {
        const [x, y] = flat(points.xyz.slice(place * 3, place * 3 + 3));
        const [red, green, blue] = points.colours.subarray(place * 3, place * 3 + 3);
        context.fillStyle = `rgb(${red},${green},${blue})`;
        context.fillRect(x - size / 2, y - size / 2, size, size);
      }
    }

    function drawCamera(context, flat, camera, role) {
      const centre = corner(camera, 0);
      const at = [1, 2, 3, 4].map((place) => flat(corner(camera, place).map((value, axis) => centre[axis] + (value - centre[axis]) * cameras.depth)));
      const from = flat(centre);
      context.strokeStyle = role.colour;
      context.lineWidth = role.width;
      context.setLineDash(role.dashed ? [3, 2] : []);
      context.beginPath();
      for (const [place, end] of at.entries()) {
        context.moveTo(...from);
        context.lineTo(...end);
        context.lineTo(...at[(place + 1) % 4]);
      }
      context.stroke();
      context.setLineDash([]);
      const number = shown.order.get(camera);
      if (number === undefined) return;
      context.fillStyle = role.colour;
      context.font = "600 11px system-ui, sans-serif";
      context.fillText(String(number), from[0] + 4, from[1] - 4);
    }

    const keys = {
      ArrowLeft: () => turn(-TURN, 0), ArrowRight: () => turn(TURN, 0), ArrowUp: () => turn(0, -TURN), ArrowDown: () => turn(0, TURN),
      "+": () => zoom(1.2), "=": () => zoom(1.2), "-": () => zoom(1 / 1.2),
      0: () => { eye = start(); draw(); },
    };
    canvas.addEventListener("keydown", (event) => {
      if (!keys[event.key]) return;
      event.preventDefault();
      event.stopPropagation();
      keys[event.key]();
    });
    let last = null;
    canvas.addEventListener("pointerdown", (event) => { last = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      turn((event.clientX - last[0]) * 0.008, (event.clientY - last[1]) * 0.008);
      last = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { last = null; });
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return; // the page scrolls until the picture is asked for
      event.preventDefault();
      zoom(event.deltaY < 0 ? 1.1 : 1 / 1.1);
    }, { passive: false });
    new ResizeObserver(draw).observe(canvas);
    return { element: canvas, update: (roles, order = new Map()) => { shown = { roles, order }; draw(); } };
  };

  avs.spaceLegend = (names) => avs.h("p.quiet.legend", {}, names.map((name) => avs.h("span.entry", {},
    avs.h(ROLES[name].dashed ? "span.key.dashed" : "span.key", { style: `border-color:${ROLES[name].colour}`, "aria-hidden": "true" }), ROLES[name].about)).flatMap((entry) => [entry, " "]));

  avs.scenePoints = (points) => ({ xyz: points.xyz, colours: avs.bytes(points.rgb) });
})();
