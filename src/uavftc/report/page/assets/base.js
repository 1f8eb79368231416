"use strict";
// What all scripts of the page share: its data, arrays out of base64, and who hears of a new time.
const uavftc = { data: JSON.parse(document.getElementById("data").textContent), plots: [], problems: [] };

window.addEventListener("error", (event) => uavftc.problems.push(String(event.message)));

uavftc.array = function (packed) {
  const text = atob(packed.data);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i += 1) bytes[i] = text.charCodeAt(i);
  const kinds = { f4: Float32Array, u2: Uint16Array, u4: Uint32Array };
  return new kinds[packed.type](bytes.buffer);
};

// Texts of the user's go into plots as text: plotly.js reads some tags.
uavftc.plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");

uavftc.number = (value, digits) => (Number(value.toFixed(digits)) + 0).toFixed(digits).replace("-", "\u2212");

uavftc.element = function (tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) made.setAttribute(name, value);
  made.append(...children);
  return made;
};

// Where a time lies among increasing samples: the place before it, and the share of the way to the next.
uavftc.place = function (times, t) {
  let low = 0, high = times.length - 1;
  if (high < 1 || t <= times[0]) return [0, 0];
  if (t >= times[high]) return [high - 1, 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return [low, (t - times[low]) / (times[high] - times[low])];
};

uavftc.at = function (values, [i, share]) {
  const next = values[Math.min(i + 1, values.length - 1)];
  return share === 0 ? values[i] : values[i] + share * (next - values[i]);
};

// The time of the page: every listener is called with it, and with the range that the plots show.
uavftc.clock = {
  t: 0, range: null, listeners: [],
  end() { const c = uavftc.data.clock; return c.start + c.step * Math.max(c.rows - 1, 0); },
  set(t, from) {
    this.t = Math.min(Math.max(t, uavftc.data.clock.start), this.end());
    for (const listener of this.listeners) listener(this.t, from);
  },
};
