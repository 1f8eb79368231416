"use strict";
// Everything begins here; `uavftc.drawn` is when all of it was drawn, in ms after the page was asked for.
(function () {
  async function copy(button) {
    const text = document.getElementById(button.dataset.copy).textContent;
    let done = false;
    try {
      await navigator.clipboard.writeText(text);
      done = true;
    } catch {  // a page from a file may not: the old way
      const area = uavftc.element("textarea", { "aria-hidden": "true" });
      area.value = text;
      document.body.append(area);
      area.select();
      done = document.execCommand("copy");
      area.remove();
    }
    const before = button.textContent;
    button.textContent = done ? "Copied" : "Select it by hand";
    setTimeout(() => { button.textContent = before; }, 1500);
  }
  for (const button of document.querySelectorAll("button[data-copy]")) {
    button.addEventListener("click", () => copy(button));
  }
  (async function () {
    uavftc.theme.start();
    if (uavftc.data.clock) uavftc.startTime();
    if (uavftc.startView) uavftc.startView();
    await uavftc.startPlots();
    if (uavftc.startPoints) await uavftc.startPoints();
    uavftc.drawn = performance.now();
    document.documentElement.dataset.drawn = uavftc.drawn.toFixed(0);
  })().catch((error) => { uavftc.problems.push(String(error)); console.error(error); });
})();
