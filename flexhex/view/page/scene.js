"use strict";
// Renderer, lights, floor, camera. `THREE` is there once `loadThree` is done.

let THREE = null;

// ES modules of the page as blobs that import one another: a browser loads no file beside a page
async function loadThree() {
  const source = id => document.getElementById(id).textContent;
  const blob = text => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  const core = blob(source("three.core.min.js"));
  const main = blob(source("three.module.min.js").replaceAll("./three.core.min.js", core));
  const orbit = blob(source("OrbitControls.js").replace("from 'three'", `from '${main}'`));
  const [three, controls] = [await import(main), await import(orbit)];
  THREE = { ...three, OrbitControls: controls.OrbitControls };
}

// where the camera stands: directions from the middle of the machine
const CAMERAS = { home: [0.6, -0.72, 0.36], top: [0, -0.001, 1], front: [0, -1, 0.26], side: [1, 0, 0.12] };
const FOV = 30;
// LATE: time between two pictures from which on they are coarse, after the first FEW of a motion;
// REST: when it is over [ms]
const LATE = 60, FEW = 5, REST = 200;
// what draws where there is no graphics card; edges smoothed by it cost more than all the rest
// SMOOTH: pixels each way for one of the screen where these smooth the edges instead
const SMOOTH = 1.5;
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

function hasCard() {
  const probe = document.createElement("canvas").getContext("webgl2");
  const names = probe?.getExtension("WEBGL_debug_renderer_info");
  return !names || !SOFTWARE.test(probe.getParameter(names.UNMASKED_RENDERER_WEBGL));
}

class Stage {
  // size: {reach, middle, floor} of the machine [m]
  constructor(canvas, size) {
    this.canvas = canvas;
    this.reach = size.reach;
    this.wide = 0;  // between the middles of two machines beside each other [m]
    this.middle = vector(size.middle);
    this.card = hasCard();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: this.card, alpha: true });
    Object.assign(this, { interval: 0, pictures: 0, still: 0 });
    const ratio = Math.min(window.devicePixelRatio, 2);
    Object.assign(this, { fine: this.card ? ratio : Math.max(ratio, SMOOTH), rough: ratio / 2 });
    this.renderer.setPixelRatio(this.fine);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.15;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(FOV, 1, 0.014 * this.reach, 43 * this.reach);
    this.camera.up.set(0, 0, 1);
    this.lights();
    this.floor(size.floor);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.onChange?.());
    this.resize();
    this.look("home");
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  lights() {
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#9fb0bf", 1.9));
    const sun = new THREE.DirectionalLight("#fff4e3", 2.6);
    const size = this.reach;
    sun.position.set(0.7 * size, -0.9 * size, 2.4 * size);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -1.6 * size, right: 1.6 * size, top: size, bottom: -size, far: 6 * size });
    sun.shadow.bias = -0.0005;
    sun.shadow.normalBias = 0.004;
    sun.shadow.radius = 5;
    this.sun = sun;
    const fill = new THREE.DirectionalLight("#cfe2ff", 0.9);
    fill.position.set(-size, size, 0.8 * size);
    this.scene.add(sun, fill);
  }

  floor(z) {
    this.shadow = new THREE.Mesh(new THREE.CircleGeometry(3 * this.reach, 64), new THREE.ShadowMaterial({ opacity: 0.18 }));
    this.shadow.position.z = z;
    this.shadow.receiveShadow = true;
    this.scene.add(this.shadow);
    const points = [];
    for (const r of [0.25, 0.5, 0.75, 1].map(f => f * this.reach)) {
      for (let k = 0; k < 96; k++) {
        for (const g of [k, k + 1]) {
          points.push(new THREE.Vector3(r * Math.cos(g * Math.PI / 48), r * Math.sin(g * Math.PI / 48), z));
        }
      }
    }
    this.grid = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial());
    this.scene.add(this.grid);
  }

  add(mechanism) { this.scene.add(mechanism.root); }

  look(name) {
    const direction = vector(CAMERAS[name]).normalize();
    this.camera.position.copy(this.middle).addScaledVector(direction, this.distance());
    this.controls.target.copy(this.middle);
    this.controls.update();
    this.onChange?.();
  }

  // from where a sphere about the machine fills the free part of the picture
  distance() {
    const half = Math.tan(FOV / 2 * Math.PI / 180);
    const free = Math.min(this.camera.aspect, 1.12 * (1 - this.covered / this.canvas.clientHeight));
    const alone = 0.72 * this.reach / half / Math.min(free, 1);
    return Math.max(alone, 0.5 * (this.wide + (this.wide ? 1.75 : 1.5) * this.reach) / half / this.camera.aspect + 0.3 * this.wide);
  }

  colours() {
    this.grid.material.color.set(css("--edge"));
    this.shadow.material.opacity = document.documentElement.classList.contains("dark") ? 0.45 : 0.2;
    this.renderer.toneMappingExposure = document.documentElement.classList.contains("dark") ? 0.95 : 1.15;
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) { return; }
    // the controls at the bottom cover a stretch: the machine stands in the middle of the rest
    this.covered = document.getElementById("bottom").offsetHeight + 12;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.setViewOffset(clientWidth, clientHeight, 0, this.covered / 2, clientWidth, clientHeight);
    this.camera.updateProjectionMatrix();
    this.onChange?.();
  }

  // a picture `interval` [ms] after the one before it, of something that moves or not: coarse where
  // those of a motion come late, or from its third on where no card draws; true where one that rests has to be drawn anew
  pace(interval, moves) {
    this.pictures = moves ? this.pictures + 1 : 0;
    this.still = moves ? 0 : this.still + interval;
    if (this.pictures > 1) { this.interval += 0.3 * (interval - this.interval); }
    if (moves) { this.coarse(this.card ? this.pictures > FEW && this.interval > LATE : this.pictures > 2); }
    return this.still > REST && this.coarse(false);
  }

  // half the pixels of the screen each way and no shadows, or all; whether that is a change
  coarse(on) {
    const ratio = on ? this.rough : this.fine;
    if (this.renderer.getPixelRatio() === ratio) { return false; }
    this.renderer.setPixelRatio(ratio);
    this.sun.castShadow = !on;
    return true;
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
    this.numbers?.();
  }
}
