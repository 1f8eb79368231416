"use strict";
// Charts without a time axis: distributions and ratios as the page describes them, and flights by two of their inputs.
(function () {
  const SYMBOLS = { survived: "circle", degraded: "diamond", lost: "x", numerical: "square", error: "square" };
  const config = { displayModeBar: false, responsive: false };
  const places = [];

  function frame(ink, place, height, x, y) {
    const line = { gridcolor: ink.grid, linecolor: ink.line, zerolinecolor: ink.grid, showline: true, automargin: true };
    const side = (one) => ({
      ...line, title: { text: uavftc.plain(one.title || ""), standoff: 8 }, type: one.type, range: one.range,
      dtick: one.type === "log" ? "D2" : undefined,
      ...(one.texts ? { tickvals: one.texts.map((_, i) => i), ticktext: one.texts.map(uavftc.plain) } : {}),
    });
    return {
      width: uavftc.theme.printing ? Math.min(690, place.clientWidth || 690) : place.clientWidth, height,
      margin: { l: 60, r: 16, t: 44, b: 52 }, paper_bgcolor: ink.ground, plot_bgcolor: ink.ground,
      font: { size: 12, color: ink.text }, hovermode: "closest", hoverlabel: { namelength: -1 },
      legend: { orientation: "h", x: 0, y: 1, yref: "container", yanchor: "top" }, xaxis: side(x), yaxis: side(y),
    };
  }

  function chart(one, place) {
    const ink = uavftc.theme.ink();
    const traces = one.series.map((series) => {
      const look = uavftc.data.looks[series.look], colour = uavftc.theme.colour(look);
      return {
        type: "scatter", mode: series.marks ? "markers" : "lines", name: uavftc.plain(series.name),
        x: series.x, y: series.y, text: (series.text || []).map(uavftc.plain),
        line: { color: colour, width: look.width, dash: look.dash, shape: series.steps ? "hv" : "linear" },
        marker: { color: colour, size: 8, symbol: series.marks, line: { color: ink.ground, width: 1 } },
        hovertemplate: series.text ? "%{text}<extra></extra>" : "%{x:.3f}: %{y:.3f}<extra>%{fullData.name}</extra>",
      };
    });
    const layout = frame(ink, place, one.height, one.x, one.y);
    const line = { color: ink.text, width: 1, dash: "dash" };
    layout.shapes = [];
    if (one.upright !== undefined) {
      layout.shapes.push({ type: "line", x0: one.upright, x1: one.upright, yref: "paper", y0: 0, y1: 1, line });
    }
    if (one.level !== undefined) {
      layout.shapes.push({ type: "line", y0: one.level, y1: one.level, xref: "paper", x0: 0, x1: 1, line });
    }
    if (one.legendBelow) layout.margin.t = 20 + 20 * Math.ceil(one.series.length * 190 / Math.max(layout.width, 1));
    return Plotly.react(place, traces, layout, config);
  }

  function scatter() {
    const place = document.getElementById("plot-scatter");
    const given = uavftc.data.scatter;
    const flights = {};
    for (const name of ["variant", "case", "margin", "outcome"]) flights[name] = uavftc.array(given[name]);
    const inputs = given.inputs.map((one) => ({ ...one, values: uavftc.array(one.y) }));
    const [across, up, of] = ["x-input", "y-input", "of-variant"].map((id) => document.getElementById(id));
    inputs.forEach((one, i) => { across.append(new Option(one.key, i)); up.append(new Option(one.key, i)); });
    up.append(new Option("margin", inputs.length));
    up.value = inputs.length > 1 ? 1 : inputs.length;
    given.variants.forEach((name, i) => of.append(new Option(name, i)));
    let shown = [];

    function draw() {
      const ink = uavftc.theme.ink(), dark = uavftc.theme.dark();
      shown = [...flights.variant.keys()].filter((i) => flights.variant[i] === Number(of.value));
      const x = inputs[Number(across.value)];
      const y = inputs[Number(up.value)] || { key: "margin", values: flights.margin, texts: null };
      const marker = {
        size: 9, color: shown.map((i) => Math.max(-1, Math.min(1, Number.isNaN(flights.margin[i]) ? -1 : flights.margin[i]))),
        symbol: shown.map((i) => SYMBOLS[given.outcomes[flights.outcome[i]]]), cmin: -1, cmax: 1,
        colorscale: [[0, "#D55E00"], [0.5, dark ? "#55585e" : "#e3e3e3"], [1, dark ? "#5aa9ff" : "#0072B2"]],
        line: { color: ink.line, width: 0.8 }, colorbar: { title: { text: "margin" }, thickness: 12 },
      };
      const text = shown.map((i) => `case ${flights.case[i]}, margin ${flights.margin[i].toFixed(3)}`);
      const trace = {
        type: "scatter", mode: "markers", x: shown.map((i) => x.values[i]), y: shown.map((i) => y.values[i]), marker, text,
        hovertemplate: "%{text}<extra></extra>",
      };
      const side = (one) => ({ title: one.key, texts: one.texts });
      const layout = frame(ink, place, 400, side(x), side(y));
      layout.margin.t = 16;
      return Plotly.react(place, [trace], layout, config);
    }
    for (const one of [across, up, of]) one.addEventListener("change", draw);
    return draw().then(() => {
      place.on("plotly_click", (event) => {
        const i = shown[event.points[0].pointIndex];
        const values = inputs.map((one) => `${one.key} = ${one.texts ? one.texts[one.values[i]] : Number(one.values[i].toPrecision(5))}`);
        document.getElementById("picked").textContent =
          `Case ${flights.case[i]}, ${given.outcomes[flights.outcome[i]]}, margin ${flights.margin[i].toFixed(3)}: ${values.join(", ")}`;
      });
      return draw;
    });
  }

  uavftc.startPoints = async function () {
    for (const one of uavftc.data.charts || []) {
      const place = document.getElementById(`plot-${one.key}`);
      await chart(one, place);
      places.push(() => chart(one, place));
    }
    if (document.getElementById("plot-scatter")) places.push(await scatter());
    const again = () => places.forEach((draw) => draw());
    uavftc.theme.listeners.push(again);
    let width = window.innerWidth;
    window.addEventListener("resize", () => {
      if (window.innerWidth !== width) again();
      width = window.innerWidth;
    });
  };
})();
