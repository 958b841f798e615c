// The one box that tells what lies under the pointer.
import {h} from "report/dom.js";

const box = h("div.tip", {role: "status", hidden: true});
document.body.append(box);

/// Shows content beside the point (x, y) of the window.
export function showTip(x, y, ...content) {
  box.replaceChildren(...content);
  box.hidden = false;
  const {width, height} = box.getBoundingClientRect();
  box.style.left = `${Math.max(4, x + 16 + width > innerWidth ? x - width - 12 : x + 16)}px`;
  box.style.top = `${Math.max(4, Math.min(y + 12, innerHeight - height - 4))}px`;
}
export const hideTip = () => (box.hidden = true);
