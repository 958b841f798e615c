// What is in this report, and how each file of it is made again.
import {h, whole, copyButton, unique, fileName} from "report/dom.js";

const benches = {
  scenes: "tandem-bench scenes --json results/scenes.json",
  narrowphase: "tandem-bench narrowphase --json results/narrowphase.json",
  broadphase: "tandem-bench broadphase --json results/broadphase.json",
  figures: "tandem-bench figures --json results/figures.json",
  flowgraph: "tandem-bench flowgraph --json results/flowgraph.json",
  peers: "tandem-bench peers --json results/peers.json",
};

export function commands(section, data) {
  const row = (what, file, holds, machine, command) => h("tr", {}, h("td.text", {}, h("b", {}, what), h("div.note", {}, holds)),
    h("td.text", {}, h("span", {title: file}, fileName(file)), h("div.note", {}, machine)),
    h("td.text", {}, h("div.rerun", {}, h("code", {}, command), copyButton(() => command))));
  const rows = [
    ...data.results.map((r) => {
      const names = r.pictures ? ["figures"] : unique(r.rows.map((x) => x.bench));
      return row(names.join(", "), r.file, r.pictures ? `${r.pictures.length} pictures` : `${whole(r.rows.length)} rows`, `${r.machine.cpu ?? ""}, ${r.machine.cores ?? "?"} cores, ${r.machine.compiler ?? ""}`, names.map((n) => benches[n] ?? `tandem-bench ${n}`).join("; "));
    }),
    ...data.runs.map((r) => row("reports of a run", r.file, `${whole(r.steps.length)} steps`, "", "tandem run SCENE --json FILE")),
    ...data.replays.map((r) => row("recording", r.file, `${r.name}, ${whole(r.recorded_steps)} steps`, "", `tandem run ${r.name} --steps ${r.recorded_steps} --record FILE`)),
    ...data.timelines.map((t) => row("timeline", t.file, `${whole(t.recorded_steps)} steps, ${t.threads} threads`, "", "tandem run SCENE --trace FILE")),
  ];
  section.append(h("p.lead", {}, "From the clone’s root ./run builds, measures short versions of everything and writes this page; the commands below, from build/release/bin, measure each part at full length. " +
    "tandem-bench report FILES -o PAGE.html then draws them. The contacts do not depend on the machine; the times do."),
  h("div.wide", {}, h("table.stacked", {}, h("thead", {}, h("tr", {}, ["what", "file, measured on", "made by"].map((t) => h("th.text", {scope: "col"}, t)))), h("tbody", {}, rows))));
  return rows.length > 0;
}
