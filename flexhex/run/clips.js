"use strict";
// The moving pictures: one page in a frame, filled with the data of the clip that a button chooses.
{
  const data = JSON.parse(document.getElementById("clips").textContent);
  const place = document.querySelector(".clips"), frame = place.querySelector("iframe");
  const buttons = data.clips.map((clip, k) => {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: clip.title });
    button.addEventListener("click", () => show(k));
    place.querySelector(".tools").append(button);
    return button;
  });
  function show(chosen) {
    buttons.forEach((button, k) => button.setAttribute("aria-pressed", k === chosen));
    frame.title = `the machine in 3D: ${data.clips[chosen].title}`;
    frame.srcdoc = data.page.replace(data.place, () => data.clips[chosen].data);
    place.querySelector("p").textContent = data.clips[chosen].text;
  }
  show(0);
  // print shows the machine as it stands
  addEventListener("beforeprint", () => { place.querySelector(".still").src = frame.contentWindow.still?.() ?? ""; });
}
