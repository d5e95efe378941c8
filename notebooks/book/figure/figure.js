// Draws the panels of a figure and lets one camera turn around them all. No library: coloured triangles, nothing else.

const FIELD_OF_VIEW = (32 * Math.PI) / 180; // as in scenewidget/figures/raster.py
const SHADERS = [
  ["VERTEX_SHADER", `
    attribute vec3 place, swung;
    attribute vec3 color;
    uniform mat4 camera;
    uniform float swing;
    varying vec3 shade;
    void main() {
      gl_Position = camera * vec4(place + swing * (swung - place), 1.0);
      shade = color;
    }`],
  ["FRAGMENT_SHADER", `
    precision mediump float;
    varying vec3 shade;
    void main() { gl_FragColor = vec4(shade, 1.0); }`],
];

/** The arrays of a figure by name, from gzip in base64. */
async function unpacked({ arrays, data }) {
  const bytes = Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(stream).arrayBuffer();
  const kinds = { uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array };
  return arrays.map(({ dtype, offset, length }) => new kinds[dtype](buffer, offset, length));
}

/** Places of all corners in metres: rows of the vertices' table, counted from its lowest corner in small steps. */
function places({ vertices, corners, low, step }, arrays) {
  const table = arrays[vertices], rows = arrays[corners];
  const found = new Float32Array(3 * rows.length);
  rows.forEach((row, i) => {
    for (let axis = 0; axis < 3; axis++) found[3 * i + axis] = low[axis] + step[axis] * table[3 * row + axis];
  });
  return found;
}

/** A colour a corner; of a triangle that has but one, three times. */
function shades({ colors }, arrays, n) {
  const given = arrays[colors];
  if (given.length === 3 * n) return given;
  const found = new Uint8Array(3 * n);
  for (let i = 0; i < n; i++) for (let k = 0; k < 3; k++) found[3 * i + k] = given[3 * Math.floor(i / 3) + k];
  return found;
}

/** From metres to the picture, as columns. */
function matrix({ azimuth, elevation, distance, target }, aspect) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  const axes = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  const along = axes.map((axis) => -axis.reduce((sum, part, i) => sum + part * target[i], 0));
  along[2] -= distance;
  const focal = 1 / Math.tan(FIELD_OF_VIEW / 2), near = 0.02 * distance, far = 8 * distance;
  const depth = (near + far) / (near - far);
  const rows = [
    [...axes[0].map((part) => (focal / aspect) * part), (focal / aspect) * along[0]],
    [...axes[1].map((part) => focal * part), focal * along[1]],
    [...axes[2].map((part) => depth * part), depth * along[2] + (2 * near * far) / (near - far)],
    [...axes[2].map((part) => -part), -along[2]],
  ];
  return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
}

function program(gl) {
  const made = gl.createProgram();
  for (const [kind, source] of SHADERS) {
    const shader = gl.createShader(gl[kind]);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  gl.useProgram(made);
  return made;
}

function buffer(gl, data) {
  const made = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, made);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  return made;
}

async function show(saved) {
  const stage = document.getElementById("stage");
  const canvas = document.createElement("canvas");
  const gl = canvas.getContext("webgl", { antialias: true });
  if (!gl) return; // the picture stays
  const arrays = await unpacked(saved);
  const used = program(gl);
  const inputs = ["place", "swung", "color"].map((name) => gl.getAttribLocation(used, name));
  inputs.forEach((input) => gl.enableVertexAttribArray(input));
  const panels = saved.panels.map((panel) => {
    const rest = places(panel, arrays), n = rest.length / 3;
    const place = buffer(gl, rest);
    const swung = panel.swung ? buffer(gl, places(panel.swung, arrays)) : place;
    return { n, hidesBack: panel.hides_back, buffers: [place, swung, buffer(gl, shades(panel, arrays, n))] };
  });
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL); // what is drawn on a surface comes after it
  gl.clearColor(1, 1, 1, 1);
  const radians = (degrees) => (degrees * Math.PI) / 180;
  const first = { ...saved.camera, azimuth: radians(saved.camera.azimuth), elevation: radians(saved.camera.elevation) };
  const camera = { ...first, target: [...first.target] };
  let isAsked = false, start = null;

  function draw(now) {
    isAsked = false;
    const scale = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.round(stage.clientWidth * scale), height = Math.round(stage.clientHeight * scale);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const each = width / panels.length, aspect = each / height;
    const further = Math.max(1, saved.aspect / aspect); // in a narrow place, all of it still fits
    gl.uniformMatrix4fv(
      gl.getUniformLocation(used, "camera"), false, matrix({ ...camera, distance: camera.distance * further }, aspect),
    );
    const swing = start === null ? 1 : Math.sin((2 * Math.PI * (now - start)) / (1000 * saved.seconds));
    gl.uniform1f(gl.getUniformLocation(used, "swing"), saved.seconds ? swing : 0);
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    panels.forEach(({ n, hidesBack, buffers }, i) => {
      gl.viewport(Math.round(i * each), 0, Math.round(each), height);
      (hidesBack ? gl.enable : gl.disable).call(gl, gl.CULL_FACE);
      buffers.forEach((data, k) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, data);
        if (k < 2) gl.vertexAttribPointer(inputs[k], 3, gl.FLOAT, false, 0, 0);
        else gl.vertexAttribPointer(inputs[k], 3, gl.UNSIGNED_BYTE, true, 0, 0);
      });
      gl.drawArrays(gl.TRIANGLES, 0, n);
    });
    if (start !== null) ask();
  }
  function ask() {
    if (!isAsked) requestAnimationFrame(draw);
    isAsked = true;
  }
  function turn(x, y) {
    camera.azimuth -= x;
    camera.elevation = Math.max(-1.569, Math.min(1.569, camera.elevation + y));
    ask();
  }
  function move(x, y) {
    const [ca, sa, ce, se] = [camera.azimuth, camera.elevation].flatMap((angle) => [Math.cos(angle), Math.sin(angle)]);
    const step = (2 * camera.distance * Math.tan(FIELD_OF_VIEW / 2)) / stage.clientHeight;
    [-sa, ca, 0].forEach((part, i) => { camera.target[i] -= step * x * part; });
    [-se * ca, -se * sa, ce].forEach((part, i) => { camera.target[i] += step * y * part; });
    ask();
  }
  function zoom(factor) {
    camera.distance = Math.max(0.05, Math.min(6, (camera.distance * factor) / first.distance)) * first.distance;
    ask();
  }

  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${document.title}. Arrow keys turn it, plus and minus zoom, Home shows it as at first.`);
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    if (event.buttons === 1 && !event.shiftKey) turn(0.008 * event.movementX, 0.008 * event.movementY);
    else move(event.movementX, event.movementY);
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return; // the reader scrolls past
    event.preventDefault();
    zoom(Math.exp(0.001 * event.deltaY));
  }, { passive: false });
  canvas.addEventListener("pointerleave", (event) => { if (!event.buttons) canvas.blur(); });
  canvas.addEventListener("dblclick", home);
  function home() {
    Object.assign(camera, first, { target: [...first.target] });
    ask();
  }
  const keys = {
    ArrowLeft: () => turn(0.1, 0), ArrowRight: () => turn(-0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
    "+": () => zoom(0.9), "-": () => zoom(1 / 0.9), Home: home,
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  const button = document.getElementById("swing");
  button?.addEventListener("click", () => {
    start = start === null ? performance.now() : null;
    button.textContent = start === null ? "Swing" : "Stop";
    ask();
  });
  new ResizeObserver(ask).observe(stage);
  stage.replaceChildren(canvas);
  document.body.dataset.turns = "true";
  ask();
}

show(JSON.parse(document.getElementById("figure").textContent));
