// The replay of a recorded scene, with the curves of its run in step below.
import {h, select, checkbox, none, rerun, whole, short, time, table} from "report/dom.js";
import {readReplay, costAt} from "report/replay_data.js";
import {Bodies} from "report/bodies.js";
import {StageGl} from "report/stage_gl.js";
import {StageFlat} from "report/stage_flat.js";
import {lineChart} from "report/chart.js";
import {onThemeChange} from "report/theme.js";

const commandOf = ({name, recorded_steps}) => `tandem run ${name} --steps ${recorded_steps} --record results/replay.record --json results/replay.jsonl`;
const rgb = (text) => { const c = d3.rgb(text); return [c.r / 255, c.g / 255, c.b / 255]; };
const still = [0.62, 0.62, 0.6], chosenColour = [0.9, 0.12, 0.45], partnerColour = [1, 0.62, 0.74];
const shapeColours = ["#4e8fb8", "#d9905a", "#7fae66", "#a880bd", "#c9ad52", "#cf7390", "#7a8a99", "#59b3a6"].map(rgb);

/// What a body's colour can mean: {text, values(frame): array by body, unit, log}.
function meanings(replay) {
  const counts = (frame) => {
    const out = new Float32Array(replay.about.bodies), c = replay.contacts[frame];
    for (let i = 0; i < c.count; ++i) { ++out[c.a[i]]; ++out[c.b[i]]; }
    return out;
  };
  return {
    contacts: {text: "contacts of the body", values: counts, unit: whole},
    narrow: {text: "narrow phase: time for the body’s pairs", values: (frame) => replay.costs.narrow[costAt(replay, frame)], unit: time, log: true},
    candidates: {text: "broad phase: candidate pairs of the body", values: (frame) => replay.costs.candidates[costAt(replay, frame)], unit: whole},
    shape: {text: "shape", values: null},
  };
}

/// The run whose contact hashes are those of the record; a run on ranks has another hash, and that of the list if it was recorded.
const runOf = (data, about) => data.runs.find((run) => run.steps.length > 0 && about.hashes.length > 0 &&
  run.steps.every((step, i) => i >= about.hashes.length || (step.list_hash ?? step.contact_hash) === about.hashes[i]));

function curvesOf(replay, run, seek) {
  const {about} = replay;
  if (!run) {
    return [lineChart([{name: "contacts", colour: "var(--s-2)", points: about.steps.map((s, i) => [s, replay.contacts[i].count])}],
      {title: "Contacts", caption: "Reports of the run (--json) would add its split, queue and times.", xLabel: "step", yLabel: "contacts", yFormat: whole, xFormat: whole, onSeek: seek, height: 170})];
  }
  const line = (name, colour, value, step) => ({name, colour, step, points: run.steps.map((s) => [s.step, value(s)])});
  const broadThreads = (s) => Number(s.split.split("-")[0]);
  const decision = (s) => s.decision ?? s.rebalance;  // of threads, or of ranks
  const decided = run.steps.filter((s) => decision(s) && decision(s).action !== "none");
  const notes = (x) => { const s = decided.find((one) => one.step === x); return s ? [`${decision(s).action}: ${decision(s).reason}`] : []; };
  const shared = {xLabel: "step", xFormat: whole, onSeek: seek, height: 185};
  return [
    lineChart([line("broad threads", "var(--broad)", broadThreads, true), line("narrow threads", "var(--narrow)", (s) => Number(s.split.split("-")[1]), true)],
      {...shared, title: "Split", caption: "Threads of each phase; dotted: the balance was looked at.", yLabel: "threads", yFormat: whole, notes, marks: decided.slice(0, 80).map((s) => ({x: s.step}))}),
    lineChart([line("batches waiting at most", "var(--accent)", (s) => s.queue_high_water ?? 0, true)], {...shared, title: "Queue", caption: "Its high-water mark in each step.", yLabel: "batches", yFormat: whole}),
    lineChart([line("detect (wall)", "var(--s-7)", (s) => s.ms.detect), line("broad (busy)", "var(--broad)", (s) => s.ms.broad), line("narrow (busy)", "var(--narrow)", (s) => s.ms.narrow)],
      {...shared, title: "Times", caption: "ms a step; busy times are summed over threads.", yLabel: "ms"}),
    lineChart([line("candidate pairs", "var(--s-5)", (s) => s.candidate_pairs), line("colliding pairs", "var(--s-3)", (s) => s.colliding_pairs), line("contacts", "var(--s-2)", (s) => s.contacts)],
      {...shared, title: "Pairs and contacts", caption: "What the step found.", yLabel: "number", yFormat: whole}),
  ];
}

function stageFor(canvas, bodies, wanted) {
  if (wanted !== "flat") {
    try { return {stage: new StageGl(canvas, bodies), gl: true}; } catch (error) { console.info(`The replay is drawn flat: ${error.message}`); }
  }
  return {stage: new StageFlat(canvas, bodies), gl: false};
}

async function show(place, number, data) {
  const about = data.replays[number];
  const replay = await readReplay(number, about), bodies = new Bodies(replay);
  const last = about.steps.length - 1, means = meanings(replay);
  // Bodies are about as far apart as they are large.
  const normalLength = (0.9 * bodies.extent().radius) / Math.sqrt(about.moving.length || 1);
  const state = {time: 0, playing: false, speed: 1, colour: "contacts", contacts: false, chosen: null, frame: -1};
  // A canvas that was refused WebGL can still be drawn on.
  const canvas = h("canvas", {tabindex: 0, role: "img", "aria-label": `${about.name}: ${whole(about.bodies)} bodies in 3D. Drag turns, the wheel zooms, right drag moves; a click picks a body; space plays.`});
  const side = h("div.side", {hidden: true, "aria-live": "polite"}), scale = h("div.scale"), rate = h("div.rate");
  const box = h("div.stage", {}, canvas, side, scale, rate);
  const slider = h("input", {type: "range", min: 0, max: last, step: 0.01, value: 0, "aria-label": "Step of the simulation", input: () => { pause(); seek(Number(slider.value)); }});
  const clock = h("output"), playButton = h("button", {type: "button", "aria-pressed": "false", click: () => (state.playing ? pause() : play())}, "play");
  place.replaceChildren(box);
  const {stage, gl} = stageFor(canvas, bodies, new URLSearchParams(location.search).get("stage"));

  const frameOf = (step) => Math.max(0, Math.min(last, d3.bisectRight(about.steps, step) - 1 + (() => {
    const i = d3.bisectRight(about.steps, step) - 1;
    return i >= 0 && i < last ? (step - about.steps[i]) / (about.steps[i + 1] - about.steps[i]) : 0;
  })()));
  const run = runOf(data, about);
  const curves = curvesOf(replay, run, (step) => { pause(); seek(frameOf(step)); });

  function paint() {
    const meaning = means[state.colour];
    const partners = new Set();
    if (state.chosen !== null) {
      const c = replay.contacts[state.frame];
      for (let i = 0; i < c.count; ++i) {
        if (c.a[i] === state.chosen) partners.add(c.b[i]);
        if (c.b[i] === state.chosen) partners.add(c.a[i]);
      }
    }
    const special = (body) => (body === state.chosen ? chosenColour : partners.has(body) ? partnerColour : null);
    const fixed = new Set(about.still.map((s) => s.body));
    if (!meaning.values) {
      scale.replaceChildren("colour: shape");
      stage.paint((body) => special(body) ?? (fixed.has(body) ? still : shapeColours[about.shape_of[body] % shapeColours.length]));
      return;
    }
    const values = meaning.values(state.frame);
    const sorted = Float32Array.from(about.moving, (body) => values[body]).sort();
    const hi = Math.max(sorted[Math.floor(0.99 * (sorted.length - 1))] ?? 1, 1e-9), lo = meaning.log ? Math.max(sorted[Math.floor(0.05 * sorted.length)] ?? 1, hi / 1e4, 1e-9) : 0;
    const part = (v) => Math.max(0, Math.min(1, meaning.log ? Math.log(Math.max(v, lo) / lo) / Math.log(Math.max(hi / lo, 1.001)) : v / hi));
    const table = d3.range(65).map((i) => rgb(d3.interpolateViridis(0.08 + (0.92 * i) / 64)));
    stage.paint((body) => special(body) ?? (fixed.has(body) ? still : table[Math.round(64 * part(values[body]))]));
    scale.replaceChildren(meaning.text, h("i", {style: `background:linear-gradient(90deg,${d3.range(9).map((i) => d3.interpolateViridis(0.08 + (0.92 * i) / 8)).join()})`}),
      h("span", {}, meaning.unit(lo)), h("span", {style: "float:right"}, `≥ ${meaning.unit(hi)}`));
  }
  function tellChosen() {
    side.hidden = state.chosen === null;
    if (state.chosen === null) return;
    const c = replay.contacts[state.frame], found = new Map();
    for (let i = 0; i < c.count; ++i) {
      if (c.a[i] !== state.chosen && c.b[i] !== state.chosen) continue;
      const other = c.a[i] === state.chosen ? c.b[i] : c.a[i], pair = found.get(other) ?? {contacts: 0, depth: 0};
      found.set(other, {contacts: pair.contacts + 1, depth: Math.max(pair.depth, c.depth[i])});
    }
    const cost = costAt(replay, state.frame), name = (body) => about.shape_names[about.shape_of[body]] || about.shapes[about.shape_of[body]].kind;
    side.replaceChildren(h("b", {}, `body ${state.chosen}, ${name(state.chosen)}`),
      h("div.note", {}, `${whole(replay.costs.candidates[cost]?.[state.chosen] ?? 0)} candidate pairs, ${time(replay.costs.narrow[cost]?.[state.chosen] ?? 0)} of narrow phase`),
      found.size ? table("touches", ["body", "contacts", "depth, mm"], [...found].map(([body, pair]) => [`${body} ${name(body)}`, pair.contacts, short(1000 * pair.depth)])) : h("div", {}, "touches nothing now"),
      h("button", {type: "button", click: () => choose(null)}, "close"));
  }
  function choose(body) { state.chosen = body; paint(); tellChosen(); contactsOf(); }
  function contactsOf() {
    const c = replay.contacts[state.frame], {chosen} = state;
    box.dataset.contacts = stage.showContacts(state.contacts || chosen !== null ? c : null, (i) => chosen === null || c.a[i] === chosen || c.b[i] === chosen, normalLength);
  }
  function seek(time) {
    state.time = Math.max(0, Math.min(last, time));
    bodies.at(state.time);
    stage.moved();
    const frame = Math.floor(state.time);
    if (frame !== state.frame) { state.frame = frame; paint(); contactsOf(); tellChosen(); }
    const next = about.steps[Math.min(last, frame + 1)], step = about.steps[frame] + (state.time - frame) * (next - about.steps[frame]);
    slider.value = state.time;
    clock.value = `step ${Math.round(step)}, ${(step * about.dt).toFixed(2)} s`;
    slider.setAttribute("aria-valuetext", clock.value);
    for (const curve of curves) curve.setCursor(Math.round(step));
    const at = 7 * (state.chosen ?? about.moving[0] ?? 0);
    box.dataset.body = [...bodies.pose.slice(at, at + 3)].map((x) => x.toFixed(3)).join(" ");
  }
  function play() {
    if (state.time >= last) seek(0);
    state.playing = true;
    playButton.textContent = "pause";
    playButton.setAttribute("aria-pressed", "true");
  }
  function pause() {
    state.playing = false;
    playButton.textContent = "play";
    playButton.setAttribute("aria-pressed", "false");
  }

  let before = performance.now(), drawn = 0, since = before;
  function loop(now) {
    if (!box.isConnected) return;
    const passed = Math.min(0.1, (now - before) / 1000);
    before = now;
    if (state.playing) {
      const frames = last > 0 ? (about.steps[last] - about.steps[0]) / last : 1;
      seek(state.time + (passed * state.speed) / (about.dt * frames));
      if (state.time >= last) pause();
    }
    if (stage.draw()) ++drawn;
    if (now - since > 1000) { rate.textContent = state.playing ? `${Math.round((1000 * drawn) / (now - since))} frames a second${gl ? "" : ", no WebGL: drawn flat"}` : gl ? "" : "no WebGL: drawn flat"; drawn = 0; since = now; }
    requestAnimationFrame(loop);
  }
  let down = null;
  canvas.addEventListener("pointerdown", (event) => (down = [event.offsetX, event.offsetY]));
  canvas.addEventListener("click", (event) => {
    if (down && Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) < 4) choose(stage.pick(event.offsetX, event.offsetY));
  });
  canvas.addEventListener("keydown", (event) => {
    const act = {" ": () => (state.playing ? pause() : play()), ArrowRight: () => { pause(); seek(Math.floor(state.time) + 1); }, ArrowLeft: () => { pause(); seek(Math.ceil(state.time) - 1); },
      Home: () => seek(0), End: () => seek(last), Escape: () => choose(null)}[event.key];
    if (act) { event.preventDefault(); act(); }
  });
  onThemeChange(() => { stage.theme(); paint(); });

  const body = h("input", {type: "number", min: 0, max: about.bodies - 1, style: "width:6.5em", change: () => {
    const chosen = body.value === "" ? null : Math.max(0, Math.min(about.bodies - 1, Number(body.value)));
    choose(chosen);
    if (chosen !== null && about.moving.includes(chosen)) stage.lookAt(chosen);
  }});
  place.append(
    h("div.time", {}, playButton, slider, clock),
    h("div.controls", {}, select("colour", Object.entries(means).map(([key, m]) => [key, m.text]), state.colour, (v) => { state.colour = v; paint(); }),
      select("speed", [["0.1", "1/10"], ["0.25", "1/4"], ["1", "as it ran"], ["2", "twice"]], "1", (v) => (state.speed = Number(v))),
      h("label", {}, "pick body", body), checkbox("contacts and normals", state.contacts, (v) => { state.contacts = v; contactsOf(); }),
      h("button", {type: "button", click: () => { stage.lookAtAll(); }}, "see all")),
    h("div.grid2", {}, curves.map((c) => c.element)),
    h("p.note", {}, `${whole(about.bodies)} bodies, ${about.steps.length} of ${about.recorded_steps} steps, from ${about.file}. Detection was run anew on ${about.cost.frames.length} of them when this page was written: ` +
      `${about.cost.equal_hashes} of ${about.cost.frames.length} contact hashes are the recorded ones. The costs in colour were measured there, each pair alone, on one thread.` + (run ? ` Curves from ${run.file}.` : "")));
  // Where something is to be seen: the impact.
  const busiest = d3.scan(replay.contacts, (p, q) => q.count - p.count);
  seek(Math.min(last, Math.round(0.45 * busiest)));
  stage.lookAtAll();
  requestAnimationFrame(loop);
}

export async function replay(section, data) {
  if (data.replays.length === 0) {
    section.append(none("It is recorded by", commandOf({name: "cubes-on-plane", recorded_steps: 240})));
    return false;
  }
  section.append(h("p.lead", {}, "What a run saw and found: poses that detection saw, contacts that it reported. Drag to turn, scroll to zoom, click a body to see what it touches."));
  const place = h("div");
  if (data.replays.length > 1)
    section.append(h("div.controls", {}, select("scene", data.replays.map((r, i) => [String(i), `${r.name} (${r.file})`]), "0", (v) => show(place, Number(v), data))));
  section.append(place, rerun(commandOf(data.replays[0])));
  await show(place, 0, data);
  return true;
}
