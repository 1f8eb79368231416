"use strict";
// Groups of panels over one time axis: one plot a group, panels below each other, all plots of a page linked.
(function () {
  const HIGH = 118, GAP = 30, ON_PAPER = 66, LEFT = 58, RIGHT = 12, BOTTOM = 40, PAPER_WIDTH = 690;

  const dashOf = (look) => look.dash;
  const alphaOf = (colour, alpha) => {
    const n = parseInt(colour.slice(1), 16);
    return `rgba(${n >> 16}, ${(n >> 8) & 255}, ${n & 255}, ${alpha})`;
  };
  const axis = (kind, i) => kind + (i === 0 ? "" : String(i + 1));

  function unpacked(group) {
    const { start, step } = uavftc.data.clock;
    for (const panel of group.panels) {
      for (const curve of panel.curves) {
        curve.x = Float64Array.from(uavftc.array(curve.rows), (row) => start + step * row);
        curve.values = uavftc.array(curve.y);
        if (panel.log) curve.values = curve.values.map((v) => Math.max(v, panel.range[0] * 1e-3));
      }
    }
  }

  function traces(group) {
    const named = new Set();
    return group.panels.flatMap((panel, i) => panel.curves.map((curve) => {
      const look = uavftc.data.looks[curve.look];
      const id = `${curve.look} ${curve.name}`;
      const first = !named.has(id);
      named.add(id);
      return {
        type: "scatter", mode: uavftc.data.clock.rows < 3 ? "lines+markers" : "lines",
        x: curve.x, y: curve.values, xaxis: axis("x", i), yaxis: axis("y", i),
        name: uavftc.plain(curve.name), legendgroup: id, showlegend: first,
        line: { color: uavftc.theme.colour(look), width: look.width, dash: dashOf(look) },
        connectgaps: false,
        hovertemplate: `%{y:.4g} ${uavftc.plain(panel.unit)}<extra>${uavftc.plain(curve.name)}</extra>`,
      };
    }));
  }

  function shapes(group) {
    const { windows = [], shades = {}, limiting } = uavftc.data;
    const ink = uavftc.theme.ink(), dark = uavftc.theme.dark();
    const made = [];
    group.panels.forEach((panel, i) => {
      const place = { xref: axis("x", i), yref: `${axis("y", i)} domain`, y0: 0, y1: 1, layer: "below" };
      panel.windows.forEach((number, k) => {
        const window_ = windows[number - 1], shade = shades[window_.kind];
        const alpha = (dark ? 1.25 : 1) * (k % 2 ? 0.3 : 0.16);
        made.push({
          ...place, type: "rect", x0: window_.start, x1: window_.end,
          fillcolor: alphaOf(shade.colour, alpha), line: { width: 0 },
          label: {
            text: String(number), textposition: "top left", padding: 2,
            font: { size: 11, color: dark ? shade.colour : shade.text },
          },
        });
        for (const x of [window_.start, window_.end]) {
          const line = { color: alphaOf(shade.colour, 0.8), width: 1 };
          made.push({ ...place, type: "line", x0: x, x1: x, line });
        }
        if (window_.known !== null) {
          const line = { color: dark ? shade.colour : shade.text, width: 1.5, dash: "dot" };
          made.push({ ...place, type: "line", x0: window_.known, x1: window_.known, line });
        }
      });
      if (limiting) {
        const line = { color: ink.text, width: 1, dash: "dashdot" };
        made.push({ ...place, layer: "above", type: "line", x0: limiting.at, x1: limiting.at, line });
      }
      for (const value of panel.limits) {
        const look = uavftc.data.looks.limit;
        const line = { color: uavftc.theme.colour(look), width: look.width, dash: dashOf(look) };
        made.push({
          type: "line", xref: `${axis("x", i)} domain`, x0: 0, x1: 1, yref: axis("y", i), y0: value, y1: value, line,
        });
      }
    });
    return made;
  }

  // Room above the first panel: its title, and as many lines of the legend as its names take, about.
  function topOf(group, width) {
    const names = [...new Set(group.panels.flatMap((panel) => panel.curves.map((curve) => curve.name)))];
    const widest = 52 + 6.8 * Math.max(...names.map((name) => name.length));  // all entries are as wide as that
    const lines = Math.ceil(names.length / Math.max(1, Math.floor((width - LEFT - RIGHT) / widest)));
    return GAP + 4 + 20 * lines;
  }

  function layout(group, width) {
    const ink = uavftc.theme.ink(), n = group.panels.length;
    const PANEL = uavftc.theme.printing ? ON_PAPER : HIGH;  // a page holds nine
    const top = topOf(group, width), inner = n * PANEL + (n - 1) * GAP, height = top + inner + BOTTOM;
    const clock = uavftc.clock;
    const range = clock.range || [uavftc.data.clock.start, Math.max(clock.end(), uavftc.data.clock.start + 1e-3)];
    const made = {
      height, width, autosize: false, margin: { l: LEFT, r: RIGHT, t: top, b: BOTTOM },
      paper_bgcolor: ink.ground, plot_bgcolor: ink.ground, font: { size: 12, color: ink.text },
      hovermode: "x", hoverlabel: { namelength: -1 }, dragmode: "zoom",
      legend: { orientation: "h", x: 0, xanchor: "left", y: 1, yref: "container", yanchor: "top" },
      shapes: shapes(group), annotations: [],
    };
    group.panels.forEach((panel, i) => {
      const above = i * (PANEL + GAP) / inner, below = (i * (PANEL + GAP) + PANEL) / inner;
      const line = { gridcolor: ink.grid, linecolor: ink.line, zerolinecolor: ink.grid };
      made[axis("xaxis", i)] = {
        ...line, anchor: axis("y", i), range: [...range], matches: i === 0 ? undefined : "x",
        showticklabels: i === n - 1, title: i === n - 1 ? { text: "time [s]", standoff: 4 } : undefined, showline: true,
        ticks: "outside", ticklen: 3, nticks: 8,
      };
      made[axis("yaxis", i)] = {
        ...line, anchor: axis("x", i), domain: [1 - below, 1 - above], fixedrange: false, nticks: 5, showline: true,
        ...(panel.log
          ? { type: "log", range: panel.range.map(Math.log10), exponentformat: "power", dtick: 1, tickfont: { size: 10 } }
          : { range: [...panel.range] }),
      };
      const room = Math.floor((width - LEFT - RIGHT) / 6.3);
      const heading = `${panel.title} [${panel.unit}]`;
      const remark = panel.remark && room > heading.length + panel.remark.length ? panel.remark : "";
      const place = { showarrow: false, yref: `${axis("y", i)} domain`, y: 1, yanchor: "bottom", xref: "x domain" };
      made.annotations.push({ ...place, x: 0, xanchor: "left", text: `<b>${uavftc.plain(heading)}</b>` });
      if (remark) {
        const font = { size: 11, color: ink.faint };
        made.annotations.push({ ...place, x: 1, xanchor: "right", text: uavftc.plain(remark), font });
      }
    });
    return made;
  }

  function widthOf(place) {
    return uavftc.theme.printing ? Math.min(PAPER_WIDTH, place.clientWidth || PAPER_WIDTH) : place.clientWidth;
  }

  // The line at the time of the page: an element over the plot, which moves without drawing it anew.
  function cursor(plot) {
    const line = plot.place.querySelector(".cursor");
    const axes = plot.place._fullLayout, x = axes && axes.xaxis;
    if (!x) return;
    const px = x.l2p(uavftc.clock.t), inside = px >= -0.5 && px <= x._length + 0.5;
    line.hidden = !inside;
    line.style.transform = `translateX(${x._offset + px}px)`;
    line.style.top = `${axes.margin.t}px`;
    line.style.height = `${axes.height - axes.margin.t - BOTTOM}px`;
  }

  let linking = false;
  async function link(range, from) {
    if (linking) return;
    linking = true;
    uavftc.clock.range = range;
    const whole = [uavftc.data.clock.start, uavftc.clock.end()];
    try {
      for (const plot of uavftc.plots) {
        if (plot !== from) await Plotly.relayout(plot.place, { "xaxis.range": [...(range || whole)] });
        cursor(plot);
      }
    } finally {
      linking = false;
    }
    uavftc.clock.set(uavftc.clock.t, "range");
  }
  uavftc.show = (range) => link(range, null);

  function draw(plot) {
    const config = { displayModeBar: false, responsive: false };
    const made = [plot.place, traces(plot.group), layout(plot.group, widthOf(plot.place)), config];
    return Plotly.react(...made).then(() => {
      if (!plot.place.querySelector(".cursor")) {
        plot.place.append(uavftc.element("div", { class: "cursor", "aria-hidden": "true" }));
      }
      cursor(plot);
    });
  }
  uavftc.redraw = () => Promise.all(uavftc.plots.map(draw));

  function listen(plot) {
    plot.place.on("plotly_relayout", () => {
      const range = plot.place._fullLayout.xaxis.range.map(Number), whole = [uavftc.data.clock.start, uavftc.clock.end()];
      const near = (one, other) => one.every((v, i) => Math.abs(v - other[i]) < 1e-6 * (whole[1] - whole[0]));
      if (!linking && !near(range, uavftc.clock.range || whole)) link(near(range, whole) ? null : range, plot);
    });
    plot.place.on("plotly_click", (event) => uavftc.clock.set(event.points[0].x, "plot"));
  }

  uavftc.startPlots = async function () {
    for (const group of uavftc.data.groups || []) {
      const place = document.getElementById(`plot-${group.key}`);
      if (!place) continue;
      unpacked(group);
      const plot = { group, place };
      uavftc.plots.push(plot);
      await draw(plot);
      listen(plot);
      await new Promise((go) => setTimeout(go, 0));  // what is drawn is seen before the rest
    }
    uavftc.clock.listeners.push(() => uavftc.plots.forEach(cursor));
    uavftc.theme.listeners.push(uavftc.redraw);
    let width = window.innerWidth;
    window.addEventListener("resize", () => {
      if (window.innerWidth !== width) uavftc.redraw();
      width = window.innerWidth;
    });
  };
})();
