"use strict";
// Draws the figures of a page: those of open sections at once, the others when their section is opened. Colours follow light
// and dark mode; every figure can be used with the keyboard and saved as PNG, SVG and CSV.
const Figures = (() => {
  // Colours of figures in light mode, and the property of the page that has their value in the present mode.
  const COLOURS = {/* colours */};
  const DARK = matchMedia("(prefers-color-scheme: dark)");
  const TOUCH = matchMedia("(pointer: coarse)");
  // Without a pointer that hovers, the buttons are always there and need room beside the figure.
  const BUTTONS_STAY = matchMedia("(hover: none)");
  const NARROW = 480;
  const CONFIG = {
    responsive: true,
    displaylogo: false,
    modeBarButtonsToRemove: ["toImage", "select2d", "lasso2d"],
  };

  // `text` of a figure with the colours of the present mode; what follows six digits is an opacity.
  function recoloured(text) {
    const page = getComputedStyle(document.documentElement);
    return text.replace(/#[0-9a-f]{6}/g, (colour) => {
      const property = COLOURS[colour];
      return (property && page.getPropertyValue(property).trim()) || colour;
    });
  }

  function draw(figure) {
    const plot = figure.querySelector(".plot");
    const { data, layout } = JSON.parse(recoloured(figure.querySelector("script").textContent));
    // A finger that drags scrolls the page; the buttons in the figure zoom.
    if (TOUCH.matches) layout.dragmode = false;
    if (BUTTONS_STAY.matches) layout.margin.r = 36;
    if (plot.clientWidth < NARROW) narrow(data, layout);
    // Zoom and hidden series survive a change between light and dark.
    layout.uirevision = 1;
    const isFirst = !figure.dataset.drawn;
    figure.dataset.drawn = "begun";
    plot.home = { "xaxis.range": [...layout.xaxis.range], "yaxis.range": [...layout.yaxis.range] };
    return Plotly.react(plot, data, layout, CONFIG).then(() => {
      if (isFirst) plot.on("plotly_afterplot", () => openToKeys(plot));
      openToKeys(plot);
      figure.dataset.drawn = "yes";
    });
  }

  // Names below a narrow figure are broken, not turned, and notes stand above their points, not beside them.
  function narrow(data, layout) {
    if (layout.meta.xaxis === "names") {
      layout.xaxis.ticktext = layout.xaxis.ticktext.map((name) => name.replace(/[ _](?=[^ ])/g, "$&<br>"));
      layout.xaxis.tickangle = 0;
    }
    for (const trace of data) if (trace.mode === "text" && trace.textposition) trace.textposition = "top center";
  }

  // Buttons and legend entries of Plotly take the pointer alone; this gives them to the keyboard too.
  function openToKeys(plot) {
    const targets = plot.querySelectorAll(".modebar-btn, .legendtoggle");
    for (const target of targets) {
      if (target.hasAttribute("tabindex")) continue;
      const isEntry = target.matches(".legendtoggle");
      const entry = isEntry && target.closest(".traces").querySelector(".legendtext");
      target.setAttribute("tabindex", "0");
      target.setAttribute("role", "button");
      target.setAttribute("aria-label", isEntry ? "show or hide " + entry.textContent : target.dataset.title);
      target.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        event.stopPropagation();
        if (isEntry) toggle(plot, entry.textContent);
        else target.click();
      });
    }
  }

  function toggle(plot, name) {
    const named = plot.data.findIndex((trace) => trace.showlegend && trace.name === name);
    if (named < 0) return;
    const group = plot.data[named].legendgroup;
    const hidden = plot.data[named].visible === "legendonly";
    const all = plot.data.flatMap((trace, i) => (i === named || (group && trace.legendgroup === group) ? [i] : []));
    Plotly.restyle(plot, { visible: hidden ? true : "legendonly" }, all).then(() => {
      const texts = [...plot.querySelectorAll(".legendtext")];
      const text = texts.find((t) => t.textContent === name);
      if (text) text.closest(".traces").querySelector(".legendtoggle").focus();
    });
  }

  // + and - zoom, arrows move, 0 goes back.
  function move(plot, key) {
    if (key === "0") return Plotly.relayout(plot, plot.home);
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key] || [0, 0];
    const zoom = { "+": 0.8, "=": 0.8, "-": 1.25 }[key] || 1;
    const change = {};
    ["xaxis", "yaxis"].forEach((axis, i) => {
      const [from, to] = plot.layout[axis].range;
      const [middle, half] = [(from + to) / 2 + (0.1 * by[i]) * (to - from), (0.5 * zoom) * (to - from)];
      change[axis + ".range"] = [middle - half, middle + half];
    });
    return Plotly.relayout(plot, change);
  }

  // What the figure shows, one row per point, in the units of its axes.
  function csv(plot) {
    const title = (axis) => (plot.layout[axis].title || {}).text || axis[0];
    const value = (axis, v) => {
      const { tickvals, ticktext } = plot.layout[axis];
      const names = (plot.layout.meta || {})[axis] === "names";
      return names && tickvals.includes(v) ? ticktext[tickvals.indexOf(v)].replaceAll("<br>", "") : v;
    };
    const back = (axis, v) => {
      const linear = (plot.layout.meta || {})[axis];
      return typeof linear === "number" && v !== null ? linear * Math.sinh(v) : value(axis, v);
    };
    const rows = [["series", title("xaxis"), title("yaxis"), "low", "high"]];
    for (const trace of plot.data) {
      if (trace.type === "heatmap") continue;
      const acrossX = trace.xaxis === "x2";
      const acrossY = trace.yaxis === "y2";
      const error = trace.error_x;
      trace.x.forEach((x, i) => {
        const y = trace.y[i];
        if (x === null || y === null) return;
        rows.push([
          (trace.name || "").trim(),
          acrossX ? "" : back("xaxis", x),
          acrossY ? "" : back("yaxis", y),
          error ? back("xaxis", x - error.arrayminus[i]) : "",
          error ? back("xaxis", x + error.array[i]) : "",
          ...(trace.mode === "text" ? [trace.text[i]] : []),
        ]);
      });
    }
    const cell = (v) => (/[",\n]/.test(v) ? '"' + String(v).replaceAll('"', '""') + '"' : v);
    return rows.map((row) => row.map(cell).join(",")).join("\n") + "\n";
  }

  function save(figure, kind) {
    const plot = figure.querySelector(".plot");
    const filename = document.title.replace(/[^A-Za-z0-9]+/g, "-").toLowerCase() + "-" + figure.id;
    if (kind !== "CSV") {
      const size = { width: plot.clientWidth, height: plot.clientHeight, scale: kind === "PNG" ? 2 : 1 };
      return Plotly.downloadImage(plot, { format: kind.toLowerCase(), filename, ...size });
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([csv(plot)], { type: "text/csv" }));
    link.download = filename + ".csv";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  const inSight = (figure) => !figure.closest("details:not([open])");
  const all = () => [...document.querySelectorAll("figure[id]")];

  // One figure after the other, so that the page can be read and scrolled meanwhile.
  function drawNext() {
    const next = all().find((figure) => !figure.dataset.drawn && inSight(figure));
    if (next) draw(next).then(() => setTimeout(drawNext));
  }

  // A link to a section opens it; `#all` opens every one.
  function followLink() {
    const name = decodeURIComponent(location.hash.slice(1));
    const sections = document.querySelectorAll("details");
    for (const section of sections) if (name === "all" || section.id === name) section.open = true;
  }

  function start() {
    for (const figure of all()) {
      const plot = figure.querySelector(".plot");
      figure.addEventListener("click", (event) => {
        if (event.target.dataset.kind) save(figure, event.target.dataset.kind);
      });
      plot.addEventListener("keydown", (event) => {
        if (event.target !== plot || event.ctrlKey || event.metaKey || event.altKey) return;
        if (!["+", "=", "-", "0", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"].includes(event.key)) return;
        event.preventDefault();
        move(plot, event.key);
      });
    }
    for (const section of document.querySelectorAll("details"))
      section.addEventListener("toggle", () => {
        if (!section.open) return;
        for (const plot of section.querySelectorAll("[data-drawn] .plot")) Plotly.Plots.resize(plot);
        drawNext();
      });
    addEventListener("hashchange", followLink);
    DARK.addEventListener("change", () => all().filter((f) => f.dataset.drawn).forEach(draw));
    addEventListener("beforeprint", () => {
      for (const section of document.querySelectorAll("details")) section.open = true;
      all().filter((figure) => !figure.dataset.drawn).forEach(draw);
    });
    followLink();
    drawNext();
  }

  start();
  return { draw };
})();
