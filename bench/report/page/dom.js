// Building elements, writing numbers.

/// Element of a tag ("div.note") with attributes (functions become listeners) and children (text, elements, lists).
export function h(tag, attributes = {}, ...children) {
  const [name, ...classes] = tag.split(".");
  const element = document.createElement(name);
  if (classes.length > 0) element.className = classes.join(" ");
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (key.startsWith("--")) element.style.setProperty(key, value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false && value !== undefined && value !== null) element.setAttribute(key, value);
  }
  element.append(...children.flat(3).filter((child) => child !== null && child !== undefined));
  return element;
}

const significant = (digits) => new Intl.NumberFormat("en", {maximumSignificantDigits: digits, useGrouping: true});
const two = significant(2), three = significant(3);
export const whole = (x) => new Intl.NumberFormat("en", {maximumFractionDigits: 0}).format(x);
/// A count for an axis: 1k, 1M.
export const brief = (x) => (x >= 1e6 ? `${three.format(x / 1e6)}M` : x >= 1e3 ? `${three.format(x / 1e3)}k` : three.format(x));
/// A ratio with two digits after the point where that says something.
export const ratio = (x) => (x < 10 ? x.toFixed(2) : x < 100 ? x.toFixed(1) : whole(x));
export const fileName = (path) => path.split("/").pop();
export const short = (x) => (x !== 0 && (Math.abs(x) < 1e-3 || Math.abs(x) >= 1e7) ? x.toExponential(1) : three.format(x));

/// A time in ns with its unit.
export function time(ns) {
  if (ns < 1e3) return `${three.format(ns)} ns`;
  if (ns < 1e6) return `${three.format(ns / 1e3)} µs`;
  if (ns < 1e9) return `${three.format(ns / 1e6)} ms`;
  return `${three.format(ns / 1e9)} s`;
}

/// An error, relative: 0 or a power.
export const error = (x) => (x === 0 ? "0" : x >= 0.01 ? two.format(x) : x.toExponential(1));

export function select(label, options, value, onChange) {
  const box = h("select", {change: () => onChange(box.value)},
    options.map((option) => {
      const [key, text] = Array.isArray(option) ? option : [option, option];
      return h("option", {value: key, selected: key === value}, text);
    }));
  return h("label", {}, label, box);
}

export function checkbox(label, checked, onChange) {
  const box = h("input", {type: "checkbox", checked, change: () => onChange(box.checked)});
  return h("label.inline", {}, box, label);
}

/// A button that puts text on the clipboard and says so.
export function copyButton(text, label = "copy") {
  const button = h("button", {type: "button", "aria-label": `${label}: ${text().slice(0, 80)}`, click: async () => {
    try {
      await navigator.clipboard.writeText(text());
    } catch {  // a page from disk may not be allowed to: the old way
      const area = h("textarea", {style: "position:fixed;opacity:0"});
      area.value = text();
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    button.textContent = "copied";
    setTimeout(() => (button.textContent = label), 1500);
  }}, label);
  return button;
}

/// The command that measures a number anew.
export const rerun = (command) =>
  h("p.rerun", {}, "rerun", h("code", {}, command), copyButton(() => command));

export function table(caption, heads, rows) {
  return h("table", {}, h("caption", {}, caption),
    h("thead", {}, h("tr", {}, heads.map((head) => h("th", {scope: "col"}, head)))),
    h("tbody", {}, rows.map((row) => h("tr", {}, row.map((cell) => h("td", {}, cell))))));
}

export const unique = (list) => [...new Set(list)];

export function none(what, command) {
  return h("div.none", {}, `No results of this in the report. `, what, rerun(command));
}
