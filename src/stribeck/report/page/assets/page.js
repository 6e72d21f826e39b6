"use strict";
// Draws the plots that the page says in its own words, in the colours of its theme.
(() => {
  const root = document.documentElement;
  const specs = JSON.parse(document.getElementById("plots").textContent);
  const shown = {}; // which view each plot has
  const paper = { wide: 690, narrow: 335 }; // CSS pixels of a column on A4
  const coarse = matchMedia("(pointer: coarse)").matches; // a finger scrolls the page, not a plot
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let ready = false;
  let printing = false;

  const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
  const faint = (name, share) => {
    const n = parseInt(colour(name).slice(1), 16);
    return `rgba(${n >> 16}, ${(n >> 8) & 255}, ${n & 255}, ${share})`;
  };
  // Plotly reads some tags in text: names of files are only text.
  const plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;")
    .replace(/>/g, "&gt;").replace(/\n/g, "<br>");
  const axis = (k) => (k ? `y${k + 1}` : "y");

  function traces(view) {
    const made = [];
    for (const line of view.lines) {
      const base = {
        type: "scatter", x: view.columns[line.x], y: view.columns[line.y], xaxis: "x",
        yaxis: axis(line.panel || 0), name: plain(line.name), showlegend: !line.same,
        legendgroup: plain(line.name), connectgaps: false, hoverinfo: line.silent ? "skip" : undefined,
      };
      const paint = colour(line.role);
      const dashes = { dashes: "dash", dotted: "dot" }[line.kind] || "solid";
      if (line.kind === "band") {
        const edge = { ...base, mode: "lines", line: { width: 0 }, hoverinfo: "skip" };
        made.push({ ...edge, showlegend: false });
        made.push({ ...edge, y: view.columns[line.low], fill: "tonexty", fillcolor: faint(line.role, 0.22) });
      } else if (line.kind === "dots") {
        made.push({ ...base, mode: "markers", marker: { color: paint, size: 3.5, opacity: 0.55 } });
      } else if (line.kind === "points" || line.kind === "rings") {
        const hollow = line.kind === "rings";
        made.push({
          ...base, mode: "markers", text: line.hover && line.hover.map(plain),
          hovertemplate: line.hover ? "%{text}<extra></extra>" : undefined,
          // Plotly prefers a line under the pointer to a mark wider than 6; of equals the last.
          marker: {
            color: hollow ? colour("page") : paint, size: hollow ? 5 : 6, symbol: line.symbols || "circle",
            line: { color: paint, width: 1.2 },
          },
        });
      } else {
        made.push({
          ...base, mode: line.kind === "marks" ? "lines+markers" : "lines", marker: { size: 4 },
          line: { color: paint, width: line.wide ? 2.6 : 1.5, dash: dashes, shape: line.kind === "steps" ? "hv" : "linear" },
        });
      }
    }
    if (view.spans.length) {
      made.push({
        type: "scatter", x: [null], y: [null], mode: "markers", name: view.shaded, hoverinfo: "skip",
        marker: { symbol: "square", size: 13, color: colour("shade") },
      });
    }
    return made;
  }

  function shapes(plot, view) {
    const made = view.spans.map(([a, b]) => ({
      type: "rect", x0: a, x1: b, y0: 0, y1: 1, xref: "x", yref: "paper", layer: "below",
      fillcolor: colour("shade"), line: { width: 0 },
    }));
    for (const level of view.levels) {
      made.push({
        type: "line", x0: 0, x1: 1, xref: "paper", y0: level.at, y1: level.at, yref: axis(level.panel || 0),
        line: { color: colour(level.role), width: 1, dash: level.dash ? "dash" : "solid" },
        label: level.name ? { text: plain(level.name), textposition: "end", font: { size: 11, color: colour("soft") } } : undefined,
      });
    }
    for (const upright of view.verticals) {
      made.push({
        type: "line", x0: upright.at, x1: upright.at, xref: "x", y0: 0, y1: 1, yref: "paper",
        line: { color: colour(upright.role), width: 1, dash: upright.dash ? "dot" : "solid" },
      });
    }
    return made;
  }

  // F_{S+} is F with S+ below.
  const indexed = (text) => plain(text).replace(/([A-Za-z])_(?:\{([^}]*)\}|(\w))/g, (_, letter, long, short) => `${letter}<sub>${long || short}</sub>`);

  // Words beside points, and what stands above the panels.
  function notes(plot, view, tops) {
    const base = { showarrow: false, font: { size: 11 } };
    const made = view.notes.map((note) => ({
      ...base, x: note.x, y: note.y, xref: "x", yref: "y", text: indexed(note.text), font: { size: 11, color: colour(note.role) },
      xanchor: note.side === "left" ? "right" : "left", xshift: note.side === "left" ? -10 : 10,
      yanchor: note.above ? "bottom" : "top", yshift: note.away * (note.y < 0 ? -1 : 1),
    }));
    plot.panels.forEach((panel, k) => {
      if (panel.title) made.push({ ...base, x: 0, y: tops[k], xref: "paper", yref: "paper", text: `<b>${plain(panel.title)}</b>`, xanchor: "left", yanchor: "bottom" });
    });
    if (view.remark) made.push({ ...base, x: 1, y: 1, xref: "paper", yref: "paper", text: plain(view.remark), xanchor: "right", yanchor: "bottom" });
    return made;
  }

  // Whole powers of ten are enough where a logarithmic axis has some of them.
  function powers(plot, view, which) {
    if (!plot.log) return undefined;
    const seen = view.lines.flatMap((line) => view.columns[line[which]]).filter((v) => v > 0);
    return Math.log10(Math.max(...seen) / Math.min(...seen)) > 1.5 ? 1 : undefined;
  }

  function layout(plot, view, box) {
    const small = plot.height < 260;
    const ink = colour("ink");
    const font = box < 500 ? 11 : 12;
    const axes = {
      tickfont: { size: plot.log ? font / 1.25 : font }, // powers of ten are drawn that much larger
      gridcolor: colour("grid"), linecolor: colour("edge"), tickcolor: colour("edge"), zeroline: false,
      showline: true, ticks: "outside", ticklen: 4, automargin: true, exponentformat: "power", minexponent: 5,
    };
    const made = {
      height: plot.height, autosize: true, font: { family: "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif", size: font, color: ink },
      paper_bgcolor: colour("page"), plot_bgcolor: colour("page"),
      margin: { l: 20, r: small ? 12 : 18, t: small ? 12 : 30, b: 36 },
      showlegend: !small && view.lines.some((line) => !line.same),
      legend: { orientation: "h", x: 0, y: 1.015, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)", font: { size: font } },
      hovermode: plot.hover, hoversubplots: "axis", dragmode: coarse ? false : "zoom",
      hoverlabel: { bgcolor: colour("card"), bordercolor: colour("edge"), font: { color: ink, size: 12 }, align: "left" },
      shapes: shapes(plot, view),
      xaxis: {
        ...axes, title: { text: plain(plot.x), standoff: 8 }, type: plot.log ? "log" : "linear",
        anchor: axis(plot.panels.length - 1), nticks: box < 500 ? 5 : undefined, dtick: powers(plot, view, "x"),
      },
    };
    const whole = plot.panels.reduce((sum, panel) => sum + panel.share, 0);
    const gap = 0.06;
    let top = 1;
    const tops = [];
    plot.panels.forEach((panel, k) => {
      tops.push(top);
      const high = (panel.share / whole) * (1 - gap * (plot.panels.length - 1));
      const range = view.ranges[k];
      made[k ? `yaxis${k + 1}` : "yaxis"] = {
        ...axes, title: { text: plain(panel.label), standoff: 6 }, type: plot.log ? "log" : "linear", anchor: "x",
        domain: [Math.max(0, top - high), top], range: range || undefined, autorange: range ? false : true,
        nticks: high * plot.height < 160 ? 4 : plot.log ? 5 : undefined, dtick: powers(plot, view, "y"),
      };
      top -= high + gap;
    });
    made.annotations = notes(plot, view, tops);
    return made;
  }

  function draw(id) {
    const plot = specs[id];
    const view = plot.views[shown[id] || 0];
    const place = document.getElementById(id);
    const box = printing ? (place.closest(".small") ? paper.narrow : paper.wide) : place.clientWidth;
    const made = layout(plot, view, box);
    if (printing) Object.assign(made, { width: box, height: box < 400 ? plot.height : 0.78 * plot.height, autosize: false });
    return Plotly.react(place, traces(view), made, { responsive: true, displayModeBar: false, doubleClick: "reset" });
  }

  function redraw() {
    if (ready) Object.keys(specs).forEach(draw);
  }

  // What a mouse can do to a plot, keys and fingers can: + and − zoom, arrows move, 0 shows all.
  function move(place, step) {
    const now = place._fullLayout && place._fullLayout.xaxis.range;
    if (!ready || !now) return false;
    const [a, b] = now;
    const [middle, half] = [(a + b) / 2, (b - a) / 2];
    const zoomed = (factor) => [middle - half * factor, middle + half * factor];
    const to = {
      "+": zoomed(0.6), "=": zoomed(0.6), "-": zoomed(1 / 0.6),
      ArrowLeft: [a - half / 2, b - half / 2], ArrowRight: [a + half / 2, b + half / 2],
    }[step];
    if (to) Plotly.relayout(place, { "xaxis.range": to });
    else if (step === "0") draw(place.id).then(() => Plotly.relayout(place, { "xaxis.autorange": true }));
    else if (step === "s") Plotly.downloadImage(place, { format: "png", scale: 2, width: place.clientWidth, height: specs[place.id].height, filename: place.id });
    else return false;
    return true;
  }

  function keys(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (move(event.currentTarget, event.key)) event.preventDefault();
  }

  function tools(place) {
    const row = place.parentElement.querySelector(".tools");
    if (!row) return;
    row.hidden = false;
    row.addEventListener("click", (event) => {
      const step = event.target.closest("button");
      if (step) move(place, step.value);
    });
  }

  const button = document.getElementById("theme");
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);
  function name() {
    button.textContent = isDark() ? "Light theme" : "Dark theme";
  }
  button.hidden = false;
  name();
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    name();
    redraw();
  });
  dark.addEventListener("change", () => { name(); redraw(); });

  for (const pick of document.querySelectorAll("select[data-plots]")) {
    pick.addEventListener("change", () => {
      for (const id of pick.dataset.plots.split(" ")) {
        shown[id] = pick.selectedIndex;
        document.getElementById(`${id}-alt`).textContent = specs[id].views[pick.selectedIndex].alt;
        if (ready) draw(id);
      }
      pick.nextElementSibling.textContent = pick.value;
    });
  }

  let theme;
  addEventListener("beforeprint", () => {
    theme = root.dataset.theme;
    root.dataset.theme = "light";
    printing = true;
    redraw();
  });
  addEventListener("afterprint", () => {
    if (theme) root.dataset.theme = theme;
    else delete root.dataset.theme;
    printing = false;
    redraw();
  });

  // The library is packed: it is most of the page. What is unpacked must have the hash that the
  // page's policy names, or the browser does not run it.
  async function unpack() {
    const packed = atob(document.getElementById("library").textContent.trim());
    const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
    if (typeof Plotly === "undefined") throw new Error("the drawing library did not start");
  }

  async function begin() {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser cannot unpack them; Chrome 80, Firefox 113, Safari 16.4 and later can");
    }
    await unpack();
    ready = true;
    for (const id of Object.keys(specs)) {
      const place = document.getElementById(id);
      place.textContent = "";
      await draw(id);
      place.addEventListener("keydown", keys);
      tools(place);
      await new Promise((go) => setTimeout(go)); // the page stays alive meanwhile
    }
    root.dataset.state = "drawn";
  }

  // A table whose heads are buttons: pressed once they sort upwards, again downwards.
  const key = (row, column) => {
    const cell = row.children[column];
    const text = cell.dataset.value ?? cell.textContent.trim();
    const value = text === "" ? NaN : Number(text);
    return Number.isNaN(value) ? text : value;
  };
  const below = (a, b) => {
    if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1; // what is no number comes last
    return typeof a === "number" ? a - b : a.localeCompare(b, undefined, { numeric: true });
  };
  for (const table of document.querySelectorAll("table.sortable")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const sort = document.createElement("button");
      sort.type = "button";
      sort.textContent = head.textContent;
      head.replaceChildren(sort);
      sort.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        for (const other of heads) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        const rows = [...table.tBodies[0].rows];
        rows.sort((a, b) => (down ? -1 : 1) * below(key(a, column), key(b, column)));
        table.tBodies[0].append(...rows);
      });
    });
  }

  if (Object.keys(specs).length === 0) root.dataset.state = "drawn";
  else begin().catch((error) => {
    root.dataset.state = "failed";
    for (const waiting of document.querySelectorAll(".canvas .waiting")) {
      waiting.textContent = `No plot: ${error.message}. What it shows is said below, and the tables are complete.`;
    }
  });
})();
