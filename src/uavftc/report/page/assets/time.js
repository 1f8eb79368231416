"use strict";
// The bar at the top: slider, play and pause, what happens when, and how much of the flight the plots show.
(function () {
  const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
  let playing = null, speed = 1;

  function lanes(windows) {
    const free = [];
    return windows.map((one) => {
      let lane = free.findIndex((until) => until <= one.start + 1e-9);
      if (lane < 0) lane = free.length;
      free[lane] = one.end;
      return lane;
    });
  }

  function bars(place) {
    const { windows, clock, shades, limiting } = uavftc.data;
    const length = Math.max(uavftc.clock.end() - clock.start, 1e-9);
    const share = (t) => `${100 * (t - clock.start) / length}%`;
    const seen = windows.filter((one) => one.end > one.start && one.start < uavftc.clock.end());
    const lane = lanes(seen);
    seen.forEach((one, i) => {
      const bar = uavftc.element("span", { class: "bar", title: `${one.number}: ${one.name}` });
      bar.textContent = `${one.number}  ${one.name}`;
      bar.style.left = share(one.start);
      bar.style.width = share(clock.start + one.end - one.start);
      bar.style.top = `${lane[i] * 15}px`;
      bar.style.setProperty("--shade", shades[one.kind].colour);
      place.append(bar);
    });
    place.style.height = `${15 * Math.min(1 + Math.max(-1, ...lane), 8)}px`;
    const view = uavftc.element("span", { class: "shown" });
    place.append(view);
    if (limiting) {
      const mark = uavftc.element("span", { class: "limit", title: `limiting moment: ${limiting.name}` });
      mark.style.left = share(limiting.at);
      place.append(mark);
    }
    uavftc.clock.listeners.push(() => {
      const range = uavftc.clock.range;
      view.hidden = !range;
      if (range) {
        view.style.left = share(Math.max(range[0], clock.start));
        view.style.right = `${100 - parseFloat(share(Math.min(range[1], uavftc.clock.end())))}%`;
      }
    });
  }

  function zoom(factor, shift) {
    const { start } = uavftc.data.clock, end = uavftc.clock.end();
    const [low, high] = uavftc.clock.range || [start, end];
    const length = Math.min((high - low) * factor, end - start);
    const middle = factor < 1 ? uavftc.clock.t : (low + high) / 2;
    const from = Math.min(Math.max(middle - length / 2 + shift * length, start), end - length);
    uavftc.show(length >= end - start - 1e-9 ? null : [from, from + length]);
  }

  function play() {
    const button = document.getElementById("play");
    if (playing !== null) {
      cancelAnimationFrame(playing);
      playing = null;
    } else {
      if (uavftc.clock.t >= uavftc.clock.end() - 1e-9) uavftc.clock.set(uavftc.data.clock.start, "play");
      let last = null;
      const step = (now) => {
        const passed = last === null ? 0 : (now - last) / 1000;
        last = now;
        uavftc.clock.set(uavftc.clock.t + speed * passed, "play");
        if (uavftc.clock.t >= uavftc.clock.end() - 1e-9) play();
        else playing = requestAnimationFrame(step);
      };
      playing = requestAnimationFrame(step);
    }
    button.textContent = playing === null ? "▶ Play" : "❚❚ Pause";
    button.setAttribute("aria-pressed", String(playing !== null));
  }

  uavftc.startTime = function () {
    const slider = document.getElementById("time");
    if (!slider) return;
    const { start, step } = uavftc.data.clock;
    Object.assign(slider, { min: start, max: uavftc.clock.end(), step: step || 0.01, value: start });
    slider.addEventListener("input", () => uavftc.clock.set(Number(slider.value), "slider"));
    const shown = document.getElementById("now");
    uavftc.clock.listeners.push((t, from) => {
      if (from !== "slider") slider.value = t;
      shown.textContent = `${uavftc.number(t, 2)} s`;
      slider.setAttribute("aria-valuetext", `${t.toFixed(2)} seconds`);
    });
    bars(document.getElementById("bars"));
    document.getElementById("play").addEventListener("click", play);
    const faster = document.getElementById("speed");
    for (const one of SPEEDS) faster.append(new Option(`× ${one}`, one, one === 1, one === 1));
    faster.addEventListener("change", () => { speed = Number(faster.value); });
    const buttons = { "zoom-in": [0.5, 0], "zoom-out": [2, 0], earlier: [1, -0.5], later: [1, 0.5] };
    for (const [id, [factor, shift]] of Object.entries(buttons)) {
      document.getElementById(id).addEventListener("click", () => zoom(factor, shift));
    }
    document.getElementById("whole").addEventListener("click", () => uavftc.show(null));
    for (const button of document.querySelectorAll("button[data-at]")) {
      button.addEventListener("click", () => uavftc.clock.set(Number(button.dataset.at), "button"));
    }
    for (const button of document.querySelectorAll("button[data-from]")) {
      button.addEventListener("click", () => {
        const from = Number(button.dataset.from), to = Number(button.dataset.to), more = 0.1 * (to - from) + 0.05;
        uavftc.clock.set(from, "button");
        uavftc.show([Math.max(from - more, start), Math.min(to + more, uavftc.clock.end())]);
      });
    }
    uavftc.clock.set(start, "start");
  };
})();
