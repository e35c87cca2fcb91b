// The scene in 3D: shapes from panda-twin's file (include/twin/render/scene_shapes.h), poses from its messages, drawn by three.js.
import * as THREE from "./three.module.min.js";
import { OrbitControls } from "./OrbitControls.js";

THREE.ColorManagement.enabled = false;  // colours are added up as they are, as MuJoCo does
const FOVY = 40;
const SKY = [[0.78, 0.85, 0.92], [0.95, 0.96, 0.97]];  // of models/scenes/floor.xml; for scenes without one
const AXIS = 0.1;  // length of the end effector's axes, m
const SLOW_MS = 100;
const MOST_SLOW = 10;

const colour = ([r, g, b]) => new THREE.Color(r, g, b);
// three.js divides what a surface reflects by pi; MuJoCo does not.
const brightness = Math.PI;

function parse(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const description = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { ...description, array: (Kind, at, count) => new Kind(buffer, 4 + length + at, count) };
}

function meshOf(file, { at, vertices, faces }) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(file.array(Float32Array, at, 3 * vertices), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(file.array(Float32Array, at + 12 * vertices, 3 * vertices), 3));
  geometry.setIndex(new THREE.BufferAttribute(file.array(Uint32Array, at + 24 * vertices, 3 * faces), 1));
  return geometry;
}

// three.js's cylinders stand along y, MuJoCo's along z.
const upright = (geometry) => geometry.rotateX(Math.PI / 2);
const ENDLESS = 20;  // half the side of a plane without a size, m

function geometryOf({ type, size: [a, b, c], mesh }, meshes) {
  switch (type) {
    case "plane": return new THREE.PlaneGeometry(2 * (a || ENDLESS), 2 * (b || ENDLESS));
    case "sphere": return new THREE.SphereGeometry(a, 32, 16);
    case "capsule": return upright(new THREE.CapsuleGeometry(a, 2 * b, 8, 24));
    case "ellipsoid": return new THREE.SphereGeometry(1, 32, 16).scale(a, b, c);
    case "cylinder": return upright(new THREE.CylinderGeometry(a, a, 2 * b, 32));
    case "box": return new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
    default: return meshes[mesh];
  }
}

function textureOf(file, { at, width, height }, repeat) {
  const rgb = file.array(Uint8Array, at, 3 * width * height);
  const rgba = new Uint8Array(4 * width * height).fill(255);
  for (let i = 0; i < width * height; ++i) rgba.set(rgb.subarray(3 * i, 3 * i + 3), 4 * i);
  const texture = new THREE.DataTexture(rgba, width, height);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.repeat.set(...repeat);
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 8;
  texture.needsUpdate = true;
  return texture;
}

function materialOf(file, geom) {
  const shininess = 128 * geom.shininess;
  const [r, g, b, opacity] = geom.colour;
  const textured = geom.texture >= 0;
  return new THREE.MeshPhongMaterial({
    color: new THREE.Color(r, g, b),
    opacity,
    transparent: opacity < 1,
    map: textured ? textureOf(file, file.textures[geom.texture], geom.repeat) : null,
    // Its highlights are as bright as MuJoCo's at their middle.
    specular: new THREE.Color().setScalar(0.3 * geom.specular * 4 / (shininess / 2 + 1)),
    shininess,
  });
}

function skyOf(file) {
  const [up, down] = file.sky ?? SKY;
  const geometry = new THREE.SphereGeometry(50, 24, 24);
  const at = geometry.attributes.position;
  const colours = new Float32Array(3 * at.count);
  for (let i = 0; i < at.count; ++i) {
    const share = (at.getZ(i) / 50 + 1) / 2;
    for (let k = 0; k < 3; ++k) colours[3 * i + k] = share * up[k] + (1 - share) * down[k];
  }
  geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.BackSide, depthWrite: false }));
}

// The light that throws shadows stands over what the view looks at.
function sunOf({ to, colour: diffuse, shadow }) {
  const sun = new THREE.DirectionalLight(colour(diffuse), brightness);
  sun.userData.from = new THREE.Vector3(...to).normalize().multiplyScalar(-4);
  sun.castShadow = shadow;
  sun.shadow.mapSize.set(2048, 2048);
  Object.assign(sun.shadow.camera, { left: -1.6, right: 1.6, top: 1.6, bottom: -1.6, near: 0.5, far: 8 });
  sun.shadow.bias = -0.0005;
  sun.shadow.normalBias = 0.01;
  return sun;
}

function axes() {
  const group = new THREE.Group();
  [[0xd63a2f, [0, 0, -Math.PI / 2]], [0x2f9e44, [0, 0, 0]], [0x2b6fd6, [Math.PI / 2, 0, 0]]].forEach(([color, turn]) => {
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.003, 0.003, AXIS, 12).translate(0, AXIS / 2, 0),
      new THREE.MeshBasicMaterial({ color }));
    const tip = new THREE.Mesh(new THREE.ConeGeometry(0.009, 0.025, 16).translate(0, AXIS, 0), shaft.material);
    for (const part of [shaft, tip]) part.rotation.set(...turn);
    group.add(shaft, tip);
  });
  group.matrixAutoUpdate = false;
  return group;
}

// Draws the scene of a file into a canvas, from where mouse, touch or turn() put the viewer. first: the first view; lost(): called when the
// browser takes the graphics away. Draws only when something has changed.
export function sceneView(canvas, buffer, first, lost) {
  const file = parse(buffer);
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
  renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
  renderer.shadowMap.enabled = true;
  const scene = new THREE.Scene();
  scene.add(skyOf(file));
  const bodies = Array.from({ length: file.bodies }, () => new THREE.Group());
  scene.add(...bodies);
  const meshes = file.meshes.map((mesh) => meshOf(file, mesh));
  for (const geom of file.geoms) {
    const shape = new THREE.Mesh(geometryOf(geom, meshes), materialOf(file, geom));
    const [w, x, y, z] = geom.quat;
    shape.position.set(...geom.pos);
    shape.quaternion.set(x, y, z, w);
    shape.castShadow = geom.type !== "plane" && geom.colour[3] === 1;
    shape.receiveShadow = true;
    bodies[geom.body].add(shape);
  }
  if (!file.geoms.some(({ type }) => type === "plane")) scene.add(new THREE.GridHelper(5, 25, 0x8a949c, 0xb9c2c9).rotateX(Math.PI / 2));
  const tool = axes();
  bodies[file.base].add(tool);

  const camera = new THREE.PerspectiveCamera(FOVY, 4 / 3, 0.02, 100);
  camera.up.set(0, 0, 1);
  const headlight = new THREE.DirectionalLight(colour(file.headlight), brightness);
  camera.add(headlight, headlight.target);
  headlight.target.position.set(0, 0, -1);
  scene.add(camera, new THREE.AmbientLight(colour(file.ambient), brightness));
  const suns = file.lights.map(sunOf);
  for (const sun of suns) scene.add(sun, sun.target);

  const controls = new OrbitControls(camera, canvas);
  Object.assign(controls, { minDistance: 0.1, maxDistance: 20, maxPolarAngle: 0.98 * Math.PI });

  const base = bodies[file.base].position;
  const seen = new THREE.Vector3();  // where the base was when the view was moved after it
  function reset() {
    const [azimuth, elevation] = [first.azimuth, first.elevation].map((angle) => angle * Math.PI / 180);
    const away = new THREE.Vector3(Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation));
    if (first.lookat) controls.target.set(...first.lookat);
    else controls.target.copy(base).add(new THREE.Vector3(0.2, 0, 0.35));
    camera.position.copy(controls.target).addScaledVector(away, -first.distance);
    controls.update();
    ask();
  }

  function turn(right, up, zoom) {
    const at = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target).applyAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
    at.theta += right;
    at.phi -= up;
    at.radius *= zoom;
    at.makeSafe();
    camera.position.setFromSpherical(at).applyAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2).add(controls.target);
    controls.update();
    ask();
  }

  // x, y, z, then w, x, y, z of a quaternion for each body from the second on. O_T_EE: of the end effector, by columns; or null.
  function place(poses, O_T_EE) {
    for (let i = 1; i < bodies.length; ++i) {
      const [px, py, pz, w, x, y, z] = poses.slice(7 * (i - 1), 7 * i);
      bodies[i].position.set(px, py, pz);
      bodies[i].quaternion.set(x, y, z, w);
    }
    tool.visible = Boolean(O_T_EE);
    if (O_T_EE) tool.matrix.fromArray(O_T_EE);
    if (isPlaced) {
      const way = base.clone().sub(seen);
      camera.position.add(way);
      controls.target.add(way);
    }
    seen.copy(base);
    if (!isPlaced) reset();
    isPlaced = true;
    ask();
  }

  let isPlaced = false;
  let isAsked = false;
  let slow = 0;
  let notBefore = 0;  // a slow browser rests as long as it has drawn, so that the page answers
  function ask() {
    if (isAsked) return;
    isAsked = true;
    const rest = notBefore - performance.now();
    if (rest > 0) setTimeout(() => requestAnimationFrame(draw), rest);
    else requestAnimationFrame(draw);
  }
  function draw() {
    isAsked = false;
    const began = performance.now();
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!isPlaced || width === 0) return;
    const ratio = slow < MOST_SLOW ? Math.min(devicePixelRatio, 2) : 1;
    if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) {
      renderer.setPixelRatio(ratio);
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
    }
    for (const sun of suns) {
      sun.target.position.copy(base);
      sun.position.copy(base).add(sun.userData.from);
    }
    renderer.render(scene, camera);
    // The next frame comes late when this one took long. Shadows are what a slow browser can do without.
    requestAnimationFrame(() => {
      const took = performance.now() - began;
      notBefore = took > SLOW_MS ? performance.now() + took : 0;
      if (slow >= MOST_SLOW) return;
      slow = took > SLOW_MS ? slow + 1 : 0;
      if (slow >= MOST_SLOW) for (const sun of suns) sun.castShadow = false;
    });
  }

  controls.addEventListener("change", ask);
  new ResizeObserver(ask).observe(canvas);
  canvas.addEventListener("webglcontextlost", lost, { once: true });
  return { place, reset, turn };
}
