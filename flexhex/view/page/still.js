"use strict";
// The machine as it stands, for print.

const AROUND = 12, LETTERS = 15;  // room above and below it, size of the runs' names [px]

// an address of the picture, cut to what is drawn, above the names of runs that stand beside each other; nothing without a machine
function still() {
  if (DATA.machine.kind === "none") { return ""; }
  stage.draw();
  const from = byId("machine"), names = [...byId("names").children], ratio = from.width / from.clientWidth;
  const [top, bottom] = drawnRows(from), room = ratio * AROUND, text = names.length ? ratio * 2 * LETTERS : 0;
  const still = Object.assign(document.createElement("canvas"), { width: from.width, height: bottom - top + 2 * room + text });
  const context = still.getContext("2d");
  context.drawImage(from, 0, room - top);
  Object.assign(context, { font: `600 ${ratio * LETTERS}px system-ui, sans-serif`, textAlign: "center", textBaseline: "bottom" });
  names.forEach((name, k) => {
    context.fillStyle = DATA.runs[k].colour;
    context.fillText(name.textContent, (k + 0.5) / names.length * still.width, still.height);
  });
  return still.toDataURL();
}

// first and last row of a canvas on which something is drawn
function drawnRows(canvas) {
  const { width, height } = canvas, copy = Object.assign(document.createElement("canvas"), { width, height });
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  const full = row => { for (let k = 4 * width * row + 3; k < 4 * width * (row + 1); k += 4) { if (data[k]) { return true; } } return false; };
  let top = 0, bottom = height;
  while (top < bottom - 1 && !full(top)) { top++; }
  while (bottom > top + 1 && !full(bottom - 1)) { bottom--; }
  return [top, bottom];
}
