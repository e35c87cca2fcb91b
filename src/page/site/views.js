// What the page shows: pictures of a camera, which panda-twin draws, or the scene in 3D, which the browser draws (scene.js).
import { explain } from "./tips.js";

const $ = (id) => document.getElementById(id);
const PICTURES = "pictures";
const SCENE = "scene";
const TIP = "Keys 1 to 9: cameras; the one who leads points the camera for all. Key 0: 3D, seen from where you like.";
const TURNS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOMS = { Comma: 1.1, Period: 1 / 1.1 };
const TURN = Math.PI / 36;

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

// Whether WebGL 2 works, and whether by a graphics processor. Without one, 3D takes all of a processor that the robot may need.
function drawing() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return { works: false, fast: false };
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const fast = !SOFTWARE.test(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return { works: true, fast };
}

// say(type, members) sends to panda-twin. replay keeps what comes, and while it is on, again() shows it instead. The returned functions take what panda-twin says.
export function views(say, replay) {
  const can = drawing();
  let shows = can.fast ? SCENE : PICTURES;
  let welcome = null;
  let token = "";
  let none = "";  // why there are no pictures
  let path = null;  // of the file that `scene` draws, or will
  let scene = null;
  let tool = null;
  let pictures = [];

  function cover(text) {
    $("no-picture").hidden = text === "";
    $("no-picture").textContent = text;
  }

  function listChoices() {
    const why = welcome.no_scene || (can.works ? "" : "this browser has no WebGL 2");
    const all = welcome.cameras.map((name, i) => new Option(name, String(i)));
    if (!why) all.unshift(new Option("3D, your own", SCENE));
    $("cameras").replaceChildren(...all);
    explain($("view"), why ? `${TIP} There is no 3D view: ${why}.` : `${TIP} ${welcome.scene.note}`);
    return !why;
  }

  async function load() {
    path = welcome.scene.path;
    cover("loading the scene");
    try {
      const [{ sceneView }, answer] = await Promise.all(
        [import("./scene.js"), fetch(path, { headers: { Authorization: `Bearer ${token}` } })]);
      if (!answer.ok) throw new Error(`panda-twin answers ${answer.status}`);
      scene = sceneView($("scene"), await answer.arrayBuffer(), welcome.scene.view, () => fail("the browser has lost its graphics"));
    } catch (error) {
      fail(error.message);
    }
  }

  function fail(why) {
    welcome.no_scene = why;
    scene = null;
    path = null;
    listChoices();
    show(PICTURES);
  }

  function show(what) {
    shows = what;
    const inScene = what === SCENE;
    $("scene").hidden = !inScene;
    $("reset").hidden = !inScene;
    if (inScene) $("cameras").value = SCENE;
    say("view", { of: what });
    cover(inScene ? "waiting for the scene" : none || "waiting for the first picture");
    if (inScene && path !== welcome.scene.path) load();
  }

  function choose(what) {
    if (what === SCENE) {
      if (shows === SCENE) scene?.reset();
      else show(SCENE);
      return;
    }
    say("camera", { number: Number(what) });
    if (shows === SCENE) show(PICTURES);
  }

  async function draw(data) {
    const picture = await createImageBitmap(data);
    const canvas = $("camera");
    if (canvas.width !== picture.width || canvas.height !== picture.height) {
      canvas.width = picture.width;
      canvas.height = picture.height;
    }
    canvas.getContext("2d").drawImage(picture, 0, 0);
    picture.close();
    if (shows !== SCENE) cover("");
  }

  function place(message, at) {
    if (shows !== SCENE || !scene) return;
    scene.place(message.bodies, at);
    cover("");
  }

  function offers(what) {
    return [...$("cameras").options].some((option) => option.value === what);
  }

  $("cameras").onchange = () => choose($("cameras").value);
  $("reset").onclick = () => scene?.reset();
  window.addEventListener("keydown", (event) => {
    if (event.target.closest("#ask") || event.altKey || event.metaKey) return;
    const digit = /^Digit(\d)$/.exec(event.code);
    if (digit && !event.ctrlKey && !event.repeat) {
      const what = digit[1] === "0" ? SCENE : String(digit[1] - 1);
      if (offers(what)) choose(what);
    }
    if (shows !== SCENE || !scene) return;
    if (event.ctrlKey && event.code in TURNS) {
      event.preventDefault();
      scene.turn(TURNS[event.code][0] * TURN, TURNS[event.code][1] * TURN, 1);
    } else if (!event.ctrlKey && event.code in ZOOMS) {
      scene.turn(0, 0, ZOOMS[event.code]);
    }
  });

  return {
    // Members of `hello`: with what the connection begins.
    hello(secret) {
      token = secret;
      return { token, of: shows };
    },
    begin(message) {
      welcome = message;
      const can3d = listChoices();
      show(shows === SCENE && can3d ? SCENE : PICTURES);
    },
    poses(message) {
      replay.keep("poses", message);
      if (!replay.isOn()) place(message, tool);
    },
    state(message) {
      tool = message.arm && message.arm.O_T_EE;
      none = message.no_picture;
      if (shows === SCENE) return;
      $("cameras").value = String(message.camera);
      if (none) cover(none);
    },
    async picture(data) {
      replay.keep("picture", data);
      if (!replay.isOn()) await draw(data);
      say("shown");
      if (shows !== SCENE) pictures.push(performance.now());
    },
    // What the replay shows: a picture and poses, null where they do not change, with the pose of the end effector then.
    again({ tool: then, picture, poses }) {
      if (picture) draw(picture);
      if (poses) place(poses, then);
    },
    // Pictures per second, over the last two seconds; null without.
    rate() {
      pictures = pictures.filter((at) => at > performance.now() - 2000);
      return shows === SCENE || pictures.length === 0 ? null : pictures.length / 2;
    },
  };
}
