// How numbers are printed, as in the tables of the run.
"use strict";

(() => {
  avs.DASH = "–";

  avs.fixed = (value, decimals) =>
    value === null || value === undefined ? avs.DASH : value.toFixed(decimals).replace("-", "−");

  avs.signed = (value, decimals) => (value === null || value === undefined
    ? avs.DASH
    : `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(decimals)}`);

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
