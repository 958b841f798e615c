// One step: threads as rows, of all ranks if there are several; tasks as bars.
import {h, select, none, rerun, whole, short} from "report/dom.js";
import {sized} from "report/chart.js";
import {showTip, hideTip} from "report/tip.js";

const colours = {update: "var(--s-7)", "broad prepare": "var(--s-5)", broad: "var(--broad)", narrow: "var(--narrow)", join: "var(--s-3)", exchange: "var(--s-2)", wait: "var(--faint)", open: "var(--ink)"};
const order = ["update", "broad prepare", "broad", "narrow", "join", "exchange", "wait", "open"];

/// Time that a thread spends in some slice; a slice may lie within another.
function busy(slices) {
  let sum = 0, end = -Infinity;
  for (const [, name, begin, duration] of slices) {
    if (name === "wait") continue;
    sum += Math.max(0, begin + duration - Math.max(begin, end));
    end = Math.max(end, begin + duration);
  }
  return sum;
}

function picture(step, rowNames, width) {
  const threads = rowNames.length;
  const row = 34, gap = 10, left = 84, queueHeight = step.queue.length ? 64 : 0, height = threads * (row + gap) + queueHeight + 38;
  const full = [0, step.length];
  const svg = sized(width, height).attr("role", "img")
    .attr("aria-label", `Step ${step.step}: ${step.slices.length} tasks on ${threads} threads in ${short(step.length)} microseconds`);
  svg.append("clipPath").attr("id", "timeline-clip").append("rect").attr("x", left).attr("width", width - left - 8).attr("height", height);
  const axis = svg.append("g").attr("transform", `translate(0,${height - 22})`);
  const rows = svg.append("g").attr("clip-path", "url(#timeline-clip)");
  for (let t = 0; t < threads; ++t) {
    const own = step.slices.filter((s) => s[0] === t);
    const at = t * (row + gap);
    svg.append("text").attr("x", 0).attr("y", at + row / 2 - 1).attr("style", "fill:var(--ink);font-weight:600").text(rowNames[t]);
    svg.append("text").attr("x", 0).attr("y", at + row / 2 + 13).text(`${Math.round((100 * busy(own)) / step.length)} % busy`);
    rows.append("rect").attr("x", left).attr("y", at).attr("width", width).attr("height", row).attr("fill", "var(--idle)");
    rows.selectAll(null).data(own).enter().append("rect").attr("class", "slice").attr("y", (s) => at + (s[1] === "narrow" ? 4 : 0))
      .attr("height", (s) => row - (s[1] === "narrow" ? 8 : 0)).attr("fill", (s) => colours[s[1]] ?? "var(--s-6)");
  }
  const top = threads * (row + gap) + 4;
  const most = d3.max(step.queue, (q) => q[1]) || 1;
  const y = d3.scaleLinear().domain([0, most]).range([top + queueHeight - 8, top + 4]);
  let line = null;
  if (queueHeight) {
    svg.append("text").attr("x", 0).attr("y", top + 16).text("queue");
    svg.append("text").attr("x", 0).attr("y", top + 30).text(`at most ${most}`);
    line = rows.append("path").attr("class", "line").attr("stroke", "var(--accent)");
  }
  const x = d3.scaleLinear().range([left, width - 8]);
  function place(domain) {
    x.domain(domain);
    const k = (width - 8 - left) / (domain[1] - domain[0]);
    rows.selectAll("rect.slice").attr("x", (s) => x(s[2])).attr("width", (s) => Math.max(0.6, s[3] * k - 0.25));
    if (line) line.attr("d", d3.line().curve(d3.curveStepAfter).x((q) => x(q[0])).y((q) => y(q[1]))(step.queue));
    axis.call(d3.axisBottom(x).ticks(width / 110).tickFormat((v) => (step.length > 2000 ? `${short(v / 1000)} ms` : `${short(v)} µs`))).select(".domain").remove();
  }
  rows.selectAll("rect.slice").on("mousemove", (s) => showTip(d3.event.clientX, d3.event.clientY, h("b", {}, s[1]),
    h("div", {}, `${short(s[3])} µs from ${short(s[2])} µs`), s[4] ? h("div", {}, `${whole(s[4])} pairs`) : "")).on("mouseleave", hideTip);
  place(full);
  const zoom = d3.zoom().scaleExtent([1, 400]).translateExtent([[left, 0], [width - 8, height]]).extent([[left, 0], [width - 8, height]])
    .filter(() => d3.event.type !== "wheel" || d3.event.ctrlKey || d3.event.shiftKey)
    .on("zoom", () => place(d3.event.transform.rescaleX(d3.scaleLinear().domain(full).range([left, width - 8])).domain()));
  svg.call(zoom);
  return {node: svg.node(), by: (factor) => svg.call(zoom.scaleBy, factor), all: () => svg.call(zoom.transform, d3.zoomIdentity),
    move: (by) => svg.call(zoom.translateBy, by, 0)};
}

export function timeline(section, data) {
  const command = "tandem run tori-and-cubes --steps 60 --trace results/timeline.json";
  if (data.timelines.length === 0) {
    section.append(none("It is recorded by", command));
    return false;
  }
  section.append(h("p.lead", {}, "What every thread did in one step. Broad-phase tiles emit batches of pairs while narrow-phase tasks already work on them. A narrow task within a broad one: the thread helped out. Grey is idle."));
  const state = {file: 0, step: 0};
  const controls = h("div.controls"), plot = h("div", {tabindex: 0, role: "group", "aria-label": "Timeline. Plus and minus zoom, arrows move, 0 shows all."}), facts = h("p.note");
  section.append(controls, h("ul.legend", {}, order.map((name) => h("li", {}, h("i.dot", {style: `background:${colours[name]};border-radius:2px`}), ` ${name}`)), h("li", {}, h("i.dot", {style: "background:var(--idle);border-radius:2px"}), " idle")),
    h("figure", {}, plot), facts, rerun(command));
  let current = null;
  function draw() {
    const file = data.timelines[state.file], step = file.steps[state.step];
    const longest = d3.scan(file.steps, (p, q) => q.length - p.length);
    controls.replaceChildren(
      data.timelines.length > 1 ? select("timeline", data.timelines.map((t, i) => [String(i), t.file]), String(state.file), (v) => { state.file = Number(v); state.step = 0; draw(); }) : "",
      select("step", file.steps.map((s, i) => [String(i), `${s.step}: ${short(s.length / 1000)} ms${i === longest ? ", the longest" : ""}`]), String(state.step), (v) => { state.step = Number(v); draw(); }),
      h("button", {type: "button", click: () => current.by(1.6)}, "zoom in"), h("button", {type: "button", click: () => current.by(1 / 1.6)}, "zoom out"), h("button", {type: "button", click: () => current.all()}, "all"));
    current = picture(step, file.rows, Math.max(300, plot.clientWidth || 800));
    plot.replaceChildren(current.node);
    const sum = (name) => d3.sum(step.slices.filter((s) => s[1] === name), (s) => s[3]);
    facts.replaceChildren(`Step ${step.step} of ${file.recorded_steps} in ${file.file}: ${whole(step.slices.length)} tasks, ${short(step.length / 1000)} ms from the first to the end of the last; ` +
      `narrow phase ${short(sum("narrow") / 1000)} ms of tasks. Drag to move, ctrl and wheel to zoom. ${step.notes.join(". ")}`);
  }
  plot.addEventListener("keydown", (event) => {
    const act = {"+": () => current.by(1.6), "-": () => current.by(1 / 1.6), 0: () => current.all(), ArrowLeft: () => current.move(60), ArrowRight: () => current.move(-60)}[event.key];
    if (act) { event.preventDefault(); act(); }
  });
  const file = data.timelines[0];
  // One of middling length tells more than the longest, which something else may have disturbed.
  state.step = d3.range(file.steps.length).sort((p, q) => file.steps[p].length - file.steps[q].length)[file.steps.length >> 1];
  draw();
  let width = plot.clientWidth;
  new ResizeObserver(() => { if (plot.clientWidth !== width) { width = plot.clientWidth; draw(); } }).observe(plot);
  return true;
}
