// What all parts share: elements, and data that is loaded on demand by scripts, since a page from disk may fetch nothing.
"use strict";

const avs = { views: {}, index: null };

(() => {
  const waiting = new Map();
  const received = new Map();

  // Scripts of data call this with their name, which is their path without suffix, and what they hold.
  avs.receive = (name, value) => {
    received.set(name, value);
    if (name === "index") avs.index = value;
  };

  // Returns a promise of what the script of this name holds; it is loaded once.
  avs.load = (name) => {
    if (!waiting.has(name)) waiting.set(name, inserted(`${name}.js`).then(() => received.get(name)));
    return waiting.get(name);
  };

  // Loads a classic script; the promise fails with one line where it is not there.
  function inserted(path) {
    return new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.src = path.split("/").map(encodeURIComponent).join("/");
      script.onload = () => resolve();
      script.onerror = () => reject(new Error(`${path} cannot be loaded; copy the whole folder of the report`));
      document.head.append(script);
    });
  }
  avs.script = (path) => {
    if (!waiting.has(path)) waiting.set(path, inserted(path));
    return waiting.get(path);
  };

  // Makes an element: attributes, properties that begin with "on" as listeners, and children; text stays text.
  avs.h = (tag, attributes, ...children) => {
    const [name, ...classes] = tag.split(".");
    return filled(document.createElement(name), classes, attributes, children);
  };

  avs.svg = (tag, attributes, ...children) =>
    filled(document.createElementNS("http://www.w3.org/2000/svg", tag), [], attributes, children);

  function filled(element, classes, attributes, children) {
    if (classes.length) element.classList.add(...classes);
    for (const [key, value] of Object.entries(attributes || {})) {
      if (value === null || value === undefined || value === false) continue;
      if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
      else if (key === "value" || key === "checked") element[key] = value;
      else element.setAttribute(key, value === true ? "" : String(value));
    }
    element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
    return element;
  }

  // Base64 to bytes.
  avs.bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

  // A line in place of something that is missing, with its reason.
  avs.missing = (reason) => avs.h("p.missing", {}, reason);

  // An element that is filled when its data have come.
  avs.later = (promise, build, told = "loading") => {
    const place = avs.h("div", { "aria-busy": "true" }, avs.h("p.quiet", {}, `${told} …`));
    promise
      .then((value) => place.replaceChildren(...[build(value)].flat()))
      .catch((error) => {
        place.replaceChildren(avs.missing(error.message));
        if (!/cannot be loaded/.test(error.message)) console.error(error);
      })
      .finally(() => place.removeAttribute("aria-busy"));
    return place;
  };

  // A choice among few or many: [value, text] pairs.
  avs.select = (label, options, value, onchange) => {
    const element = avs.h(
      "select",
      { onchange: () => onchange(element.value), "aria-label": label },
      options.map(([key, text]) => avs.h("option", { value: key, selected: key === value }, text)),
    );
    return avs.h("label.field", {}, avs.h("span", {}, label), element);
  };
})();
