// Unpacks the data and draws the sections.
import {h} from "report/dom.js";
import {readData} from "report/data.js";
import {headline} from "report/headline.js";
import {accuracy} from "report/accuracy.js";
import {figures} from "report/figures.js";
import {replay} from "report/replay.js";
import {timeline} from "report/timeline.js";
import {broadphase} from "report/broadphase.js";
import {scaling} from "report/scaling.js";
import {commands} from "report/commands.js";

const sections = [
  ["scenes", "The four scenes", headline],
  ["accuracy", "Speed against error", accuracy],
  ["figures", "The paper’s figures", figures],
  ["replay", "A replay", replay],
  ["timeline", "One step, by thread", timeline],
  ["broadphase", "Broad phase", broadphase],
  ["scaling", "Scaling", scaling],
  ["commands", "Measuring it again", commands],
];

function fault(error) {
  console.error(error);
  return h("div.fault", {role: "alert"}, `This part could not be drawn: ${error.stack ?? error}`);
}

function header(data) {
  const machine = data.results[0]?.machine ?? data.machine;
  const machines = new Set(data.results.map((r) => JSON.stringify([r.machine.cpu, r.machine.cores])));
  const versions = Object.entries(machine.versions ?? {}).map(([name, version]) => `${name} ${version}`).join(", ");
  const fact = (name, value) => (value ? h("li", {}, `${name} `, h("b", {}, String(value))) : null);
  document.getElementById("top").append(
    h("h1", {}, "tandem, measured"),
    h("p.lead", {}, "Collision detection whose broad and narrow phase run at once, as a balanced task graph. Every number below was " +
      "measured; the command that measures it again stands beside it."),
    h("ul.facts", {}, fact("CPU", machine.cpu), fact("cores", machine.cores), fact("memory", machine.memory),
      fact("compiler", machine.compiler), fact("build", (machine.flags ?? "").trim()), fact("with", versions), fact("written", data.written)),
    machines.size > 1 ? h("p.note", {}, "The results below come from more than one machine; each section names its files.") : "");
}

function watchSections(links) {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries)
      if (entry.isIntersecting) for (const link of links) {
        if (link.getAttribute("href") === `#${entry.target.id}`) link.setAttribute("aria-current", "true");
        else link.removeAttribute("aria-current");
      }
  }, {rootMargin: "-20% 0px -70% 0px"});
  document.querySelectorAll("section").forEach((section) => seen.observe(section));
}

async function draw() {
  const main = document.getElementById("main");
  const data = await readData();
  header(data);
  const links = sections.map(([id, title]) => h("a", {href: `#${id}`}, title));
  document.getElementById("contents").append(h("ol", {}, links.map((link) => h("li", {}, link))));
  document.getElementById("loading").remove();
  for (const [i, [id, title, make]] of sections.entries()) {
    const section = h("section", {id, "aria-labelledby": `${id}-title`}, h("h2", {id: `${id}-title`}, title));
    main.append(section);
    await new Promise((done) => setTimeout(done));  // what is drawn can be read meanwhile
    try {
      const filled = await make(section, data);
      section.dataset.filled = String(filled);
      if (!filled) links[i].classList.add("empty");
    } catch (error) {
      section.append(fault(error));
      section.dataset.filled = "false";
    }
  }
  document.getElementById("foot").append(h("p", {}, `Written by tandem-bench report ${data.version}, ${data.written}. This file is complete: it loads nothing. ` +
    "Drawn with three.js and d3; their licences are in the file."));
  watchSections(links);
  document.documentElement.dataset.ready = "true";
}

draw().catch((error) => {
  document.getElementById("main").append(fault(error));
  document.documentElement.dataset.ready = "failed";
});
