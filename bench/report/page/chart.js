// Curves over a shared axis: hover or arrow keys read values, dragging zooms, a double click or Escape shows all again.
import {h, short, whole} from "report/dom.js";
import {showTip, hideTip} from "report/tip.js";

export const margin = {top: 24, right: 14, bottom: 36, left: 58};

/// Few labelled ticks on a logarithmic axis, whatever its length.
export function logTicks(scale, most = 6) {
  const [lo, hi] = scale.domain().map(Math.log10);
  const every = Math.max(1, Math.ceil((hi - lo) / most));
  const powers = d3.range(Math.ceil(lo - 1e-9), Math.floor(hi + 1e-9) + 1, every).map((p) => 10 ** p);
  if (hi - lo > 2.2) return powers;
  if (hi - lo < 0.5) return d3.ticks(...scale.domain(), 5).filter((v) => v > 0);
  return scale.ticks(8).filter((v) => [1, 2, 5].includes(Math.round(v / 10 ** Math.floor(Math.log10(v) + 1e-9))));
}

const isLog = (scale) => scale.base !== undefined;

export function drawAxes(svg, {x, y, width, height, xLabel, yLabel, xTicks, yTicks, xFormat = short, yFormat = short}) {
  const inner = height - margin.bottom;
  const axis = (generator, scale, ticks, format) => {
    const made = generator(scale).tickFormat(format).tickSizeOuter(0);
    if (Array.isArray(ticks)) return made.tickValues(ticks);
    return format === whole && !isLog(scale) ? made.tickValues(scale.ticks(ticks).filter(Number.isInteger)) : made.ticks(ticks);
  };
  svg.append("g").attr("class", "axis").attr("transform", `translate(0,${inner})`)
    .call(axis(d3.axisBottom, x, xTicks ?? Math.max(3, Math.floor(width / 90)), xFormat).tickSize(-(inner - margin.top)).tickPadding(7))
    .attr("font-family", null).select(".domain").remove();
  svg.append("g").attr("class", "axis").attr("transform", `translate(${margin.left},0)`)
    .call(axis(d3.axisLeft, y, yTicks ?? 5, yFormat).tickSize(-(width - margin.left - margin.right)).tickPadding(7))
    .select(".domain").remove();
  svg.append("text").attr("x", width - margin.right).attr("y", height - 2).attr("text-anchor", "end").text(xLabel);
  svg.append("text").attr("x", 0).attr("y", 11).text(yLabel);
}

/// An SVG of a size, which paper and narrow windows may scale.
export const sized = (width, height) =>
  d3.create("svg").attr("width", width).attr("height", height).attr("viewBox", `0 0 ${width} ${height}`);

/// What a curve is called in the legend, and hidden by: several may belong together.
const groupOf = (s) => s.group ?? s.name;

/// Buttons that hide and show curves. hidden: the names that are.
export function legend(series, hidden, onChange) {
  const first = new Map([...series].reverse().map((s) => [groupOf(s), s]));
  return h("ul.legend", {"aria-label": "Curves; press one to hide it"}, [...first.keys()].reverse().map((name) => {
    const s = first.get(name);
    const button = h("button", {type: "button", "aria-pressed": String(!hidden.has(name)), click: () => {
      if (hidden.has(name)) hidden.delete(name); else hidden.add(name);
      button.setAttribute("aria-pressed", String(!hidden.has(name)));
      onChange();
    }}, h(s.dots && !s.joined ? "i.dot" : "i", {"--c": s.colour}), name);
    return h("li", {}, button);
  }));
}

/// series: [{name, group?, colour, points: [[x, y]...] by x, dashed?, dots?, joined?, step?, strong?, guide?}]; a guide
/// does not widen the axis.
/// options: title, caption, label (for screen readers), xLabel, yLabel, xLog, yLog, fromZero, height, xFormat, yFormat,
/// onSeek(x) on a click, notes(x): lines that the tip adds, marks: [{x, colour}], hidden: names of hidden curves, where
/// charts share one legend.
/// Returns {element, draw(), setCursor(x)}.
export function lineChart(series, options) {
  const {xFormat = short, yFormat = short} = options;
  const height = options.height ?? 250;
  const hidden = options.hidden ?? new Set();
  const xs = [...new Set(series.flatMap((s) => s.points.map((p) => p[0])))].sort((a, b) => a - b);
  const full = d3.extent(xs);
  let domain = full, cursor = null, scaleX = null, rule = null;

  const plot = h("div", {tabindex: 0, role: "group", "aria-label": `${options.label ?? options.title}. Arrow keys read values.`});
  const legendPlace = h("div");
  const element = h("figure", {}, options.title ? h("h3", {}, options.title) : null,
    options.caption ? h("figcaption", {}, options.caption) : null, legendPlace, plot);

  function nearest(x) {
    const i = d3.bisectLeft(xs, x);
    if (i === 0) return xs[0];
    if (i === xs.length) return xs[i - 1];
    return x - xs[i - 1] < xs[i] - x ? xs[i - 1] : xs[i];
  }
  function valueAt(s, x) {
    const i = d3.bisectLeft(s.points.map((p) => p[0]), x);
    return s.points[i] && s.points[i][0] === x ? s.points[i][1] : null;
  }
  function tell(x, clientX, clientY) {
    const lines = series.filter((s) => !hidden.has(groupOf(s))).map((s) => [s, valueAt(s, x)]).filter((l) => l[1] !== null);
    const noted = options.notes ? options.notes(x) : [];
    showTip(clientX, clientY, h("b", {}, `${options.xLabel} ${xFormat(x)}`),
      h("table", {}, lines.map(([s, y]) => h("tr", {}, h("td.text", {}, h("i", {"--c": s.colour}), s.name), h("td", {}, yFormat(y))))),
      ...noted.map((text) => h("div", {}, text)));
    place(x);
  }
  function place(x) {
    if (!rule || !scaleX) return;
    const [lo, hi] = scaleX.domain();
    rule.attr("display", x === null || x < lo || x > hi ? "none" : null).attr("x1", scaleX(x ?? lo)).attr("x2", scaleX(x ?? lo));
  }

  function draw() {
    const width = Math.max(240, plot.clientWidth || 640);
    const shown = series.filter((s) => !hidden.has(groupOf(s)));
    const inside = shown.filter((s) => !s.guide).flatMap((s) => s.points.filter((p) => p[0] >= domain[0] && p[0] <= domain[1]).map((p) => p[1]));
    let [lo, hi] = d3.extent(inside.filter((y) => !options.yLog || y > 0));
    if (lo === undefined) [lo, hi] = [options.yLog ? 0.1 : 0, 1];
    if (!options.yLog && options.fromZero !== false) lo = Math.min(0, lo);
    if (hi === lo) hi = lo + (Math.abs(lo) || 1);
    const x = (options.xLog ? d3.scaleLog() : d3.scaleLinear()).domain(domain[0] === domain[1] ? [domain[0] - 1, domain[1] + 1] : domain)
      .range([margin.left, width - margin.right]);
    const y = (options.yLog ? d3.scaleLog() : d3.scaleLinear()).domain(options.yLog ? [lo / 1.25, hi * 1.25] : [lo, hi * 1.04])
      .range([height - margin.bottom, margin.top]);
    scaleX = x;
    const svg = sized(width, height).attr("role", "img").attr("aria-label", options.label ?? options.title);
    drawAxes(svg, {x, y, width, height, xLabel: options.xLabel, yLabel: options.yLabel, xFormat, yFormat,
      xTicks: options.xTicks ?? (options.xLog ? logTicks(x) : undefined), yTicks: options.yLog ? logTicks(y) : undefined});
    const clip = `clip-${Math.random().toString(36).slice(2)}`;
    svg.append("clipPath").attr("id", clip).append("rect").attr("x", margin.left - 4).attr("y", margin.top - 4)
      .attr("width", width - margin.left - margin.right + 8).attr("height", height - margin.bottom - margin.top + 8);
    const body = svg.append("g").attr("clip-path", `url(#${clip})`);
    for (const mark of options.marks ?? []) {
      body.append("line").attr("x1", x(mark.x)).attr("x2", x(mark.x)).attr("y1", margin.top).attr("y2", height - margin.bottom)
        .attr("stroke", mark.colour ?? "var(--faint)").attr("stroke-dasharray", "1 3");
    }
    for (const s of shown) {
      const points = s.points.filter((p) => !options.yLog || p[1] > 0);
      if (!s.dots || s.joined)
        body.append("path").attr("class", `line${s.dashed ? " simulated" : ""}${s.strong ? " strong" : ""}`).attr("stroke", s.colour).datum(points)
          .attr("d", d3.line().curve(s.step ? d3.curveStepAfter : d3.curveLinear).x((p) => x(p[0])).y((p) => y(p[1])));
      if (s.dots || points.length === 1)
        body.selectAll(null).data(points).enter().append("circle").attr("cx", (p) => x(p[0])).attr("cy", (p) => y(p[1])).attr("r", 3.4)
          .attr("stroke", s.colour).attr("stroke-width", 1.5).attr("fill", s.dashed ? "var(--card)" : s.colour);
    }
    rule = svg.append("line").attr("class", "cursor").attr("y1", margin.top).attr("y2", height - margin.bottom);
    place(cursor);

    const brush = d3.brushX().extent([[margin.left, margin.top], [width - margin.right, height - margin.bottom]]).on("end", () => {
      const selected = d3.event.selection;
      if (!selected || !d3.event.sourceEvent) return;
      const [from, to] = selected.map(x.invert);
      if (selected[1] - selected[0] > 4) zoom([nearest(from), nearest(to)]);
    });
    const over = svg.append("g").attr("class", "brush").call(brush);
    over.on("mousemove", () => {
      const event = d3.event;
      tell(nearest(x.invert(d3.mouse(svg.node())[0])), event.clientX, event.clientY);
    }).on("mouseleave", () => { hideTip(); place(cursor); })
      .on("click", () => options.onSeek && options.onSeek(nearest(x.invert(d3.mouse(svg.node())[0]))))
      .on("dblclick", () => zoom(full));
    plot.replaceChildren(svg.node());
    if (series.length > 1 && !options.hidden) legendPlace.replaceChildren(legend(series, hidden, draw));
  }
  function zoom(to) {
    domain = to[0] === to[1] ? full : to;
    hideTip();
    draw();
  }
  let read = null;
  plot.addEventListener("keydown", (event) => {
    if (event.key === "Escape") { zoom(full); hideTip(); return; }
    const by = {ArrowRight: 1, ArrowLeft: -1, PageDown: 20, PageUp: -20}[event.key];
    if (!by || scaleX === null) return;
    event.preventDefault();
    const at = read === null ? 0 : xs.indexOf(read);
    read = xs[Math.max(0, Math.min(xs.length - 1, at + by))];
    const rect = plot.getBoundingClientRect();
    tell(read, rect.left + scaleX(read), rect.top + 20);
    if (options.onSeek) options.onSeek(read);
  });
  plot.addEventListener("blur", () => { hideTip(); place(cursor); });
  let drawnWidth = 0;
  new ResizeObserver(() => {
    if (plot.clientWidth === drawnWidth || plot.clientWidth === 0) return;
    drawnWidth = plot.clientWidth;
    draw();
  }).observe(plot);
  return {element, draw: () => plot.clientWidth > 0 && draw(), setCursor: (x) => { cursor = x; place(x); }};
}
