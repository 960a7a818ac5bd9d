// How numbers are printed, as in the tables of the run.
"use strict";

(() => {
  avs.DASH = "–";
  const MOST_DECIMALS = 100; // that toFixed gives; enough to tell a value that lies halfway

  // The digits that Python prints: what lies halfway goes to the even one, where toFixed takes the larger; no sign of zero.
  avs.printed = (value, decimals) => {
    const size = Math.abs(value);
    const all = size.toFixed(MOST_DECIMALS);
    const cut = all.length - MOST_DECIMALS + decimals;
    const tie = /^50*$/.test(all.slice(cut));
    const below = all.slice(0, decimals ? cut : cut - 1);
    const text = tie && "02468".includes(below.at(-1)) ? below : size.toFixed(decimals);
    return value < 0 && Number(text) ? `-${text}` : text;
  };

  avs.fixed = (value, decimals) =>
    value === null || value === undefined ? avs.DASH : avs.printed(value, decimals).replace("-", "−");

  avs.signed = (value, decimals) => {
    if (value === null || value === undefined) return avs.DASH;
    const text = avs.printed(value, decimals);
    return Number(text) > 0 ? `+${text}` : text.replace("-", "−");
  };

  // About four digits of a number of any size.
  avs.short = (value) => {
    if (value === null || value === undefined) return avs.DASH;
    const size = Math.abs(value);
    const text = size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(2) : String(Number(value.toPrecision(4)));
    return text.replace("-", "−");
  };

  avs.seconds = (value) => (value >= 100 ? `${Math.round(value)} s` : `${avs.short(Number(value.toPrecision(2)))} s`);

  avs.megabytes = (bytes) => `${Math.round(bytes / 1e6)} MB`;

  avs.mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

  avs.METRICS = {
    psnr: { name: "PSNR", unit: "dB", decimals: 2, higher: true },
    ssim: { name: "SSIM", unit: "", decimals: 3, higher: true },
    lpips: { name: "LPIPS", unit: "", decimals: 3, higher: false },
  };
})();
