"use strict";
// Light and dark: as the system asks, or as the button says; on paper always light.
uavftc.theme = {
  listeners: [], printing: false,
  dark() {
    if (this.printing) return false;
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;
  },
  colour(look) { return this.dark() ? look.dark : look.light; },
  ink() {
    return this.dark()
      ? { text: "#e6e6e6", faint: "#a8a8a8", grid: "#3a3d42", ground: "#1b1d21", line: "#8a8d93" }
      : { text: "#1d1f23", faint: "#5a5d63", grid: "#e2e2e2", ground: "#ffffff", line: "#777777" };
  },
  tell() {
    const button = document.getElementById("theme");
    button.setAttribute("aria-pressed", String(this.dark()));
    button.textContent = this.dark() ? "Light" : "Dark";
    for (const listener of this.listeners) listener();
  },
  start() {
    document.getElementById("theme").addEventListener("click", () => {
      document.documentElement.dataset.theme = this.dark() ? "light" : "dark";
      this.tell();
    });
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.tell());
    const closed = new Set();
    window.addEventListener("beforeprint", () => {
      this.printing = true;
      for (const one of document.querySelectorAll("details:not([open])")) { one.open = true; closed.add(one); }
      this.tell();
    });
    window.addEventListener("afterprint", () => {
      this.printing = false;
      for (const one of closed) one.open = false;
      closed.clear();
      this.tell();
    });
    this.tell();
  },
};
