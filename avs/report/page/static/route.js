// The state of the page is in its address, after the #, so that a view can be sent: parts by "/", then settings as in a query.
"use strict";

(() => {
  avs.parse = (hash) => {
    const [path, query] = hash.replace(/^#\/?/, "").split("?");
    const parts = path.split("/").filter(Boolean).map(decoded);
    return { parts, settings: Object.fromEntries(new URLSearchParams(query || "")) };
  };

  function decoded(text) {
    try {
      return decodeURIComponent(text);
    } catch {
      return text;
    }
  }

  avs.address = (parts, settings = {}) => {
    const told = Object.entries(settings).filter(([, value]) => value !== null && value !== undefined && value !== "");
    const query = new URLSearchParams(told.map(([key, value]) => [key, String(value)])).toString();
    return `#${parts.map(encodeURIComponent).join("/")}${query ? `?${query.replaceAll("%2C", ",")}` : ""}`;
  };

  // Changes settings of the address without a new entry in the history, and without drawing the page anew.
  // An address that does not say what is shown takes the parts that are `usual`.
  avs.keep = (changes, usual = []) => {
    const { parts, settings } = avs.parse(location.hash);
    history.replaceState(null, "", avs.address(parts.length < usual.length ? usual : parts, { ...settings, ...changes }));
  };

  avs.go = (parts, settings) => {
    location.hash = avs.address(parts, settings);
  };
})();
