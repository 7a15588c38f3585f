// Shows a model in the players of others, for tests: what is visible at a time, vertex by vertex, in world coordinates.
// model_players.py bundles it for a page. In each `open(player, file)`, then `pose(animation, seconds)`.
import * as THREE from "three";
import { MeshoptDecoder } from "three/examples/jsm/libs/meshopt_decoder.module.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { USDLoader } from "three/examples/jsm/loaders/USDLoader.js";

const LEAST = 1e-9;

function shownByThree(root) {
  root.updateWorldMatrix(true, true);
  // Some players put a model where it looks best.
  const back = root.parent ? root.parent.matrixWorld.clone().invert() : new THREE.Matrix4();
  const found = {};
  const place = new THREE.Vector3();
  root.traverseVisible((mesh) => {
    if (!mesh.isMesh || new THREE.Vector3().setFromMatrixScale(mesh.matrixWorld).length() < LEAST) return;
    const points = [];
    for (let k = 0; k < mesh.geometry.attributes.position.count; k++) {
      points.push(...mesh.getVertexPosition(k, place).applyMatrix4(mesh.matrixWorld).applyMatrix4(back).toArray());
    }
    const materials = [mesh.material].flat();
    const [{ color, name }] = materials;
    const map = materials.some((each) => each.map);
    let named = mesh;
    while (named.parent && !/epoch|threads|hooks|bed/i.test(named.name)) named = named.parent;
    (found[named.name] ??= []).push({ points, material: name, color: color.toArray(), picture: Boolean(map) });
  });
  return found;
}

function drawn(scene, box) {
  const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  renderer.setSize(640, 360);
  document.body.replaceChildren(renderer.domElement);
  const middle = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3()).length();
  const camera = new THREE.PerspectiveCamera(30, 16 / 9, 0.01 * size, 10 * size);
  camera.position.copy(middle).add(new THREE.Vector3(0.15, 1, 0.9).setLength(1.5 * size));
  camera.lookAt(middle);
  const light = new THREE.DirectionalLight(0xffffff, 2.2);
  light.position.set(-0.6, 1, 0.5);
  scene.add(light, new THREE.AmbientLight(0xffffff, 0.8));
  scene.background = new THREE.Color(0xffffff);
  renderer.render(scene, camera);
  return { fault: renderer.getContext().getError(), ...colors(renderer) };
}

// The picture's colors: of the pixels that something covers, how many there are, and their mean in sRGB.
function colors(renderer) {
  const copy = new OffscreenCanvas(640, 360);
  const pen = copy.getContext("2d");
  pen.drawImage(renderer.domElement, 0, 0);
  const { data } = pen.getImageData(0, 0, 640, 360);
  const sum = [0, 0, 0];
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    if (Math.min(data[k], data[k + 1], data[k + 2]) > 250) continue;
    count++;
    for (let c = 0; c < 3; c++) sum[c] += data[k + c];
  }
  return { count, mean: sum.map((each) => each / Math.max(1, count)) };
}

const players = {
  three: async (file) => {
    const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync(file);
    const mixer = new THREE.AnimationMixer(gltf.scene);
    const scene = new THREE.Scene();
    scene.add(gltf.scene);
    return {
      animations: gltf.animations.map((each) => each.name),
      pose: (name, seconds) => {
        mixer.stopAllAction();
        const clip = gltf.animations.find((each) => each.name === name);
        const action = mixer.clipAction(clip);
        action.setLoop(THREE.LoopOnce, 1).clampWhenFinished = true;
        action.play();
        mixer.setTime(seconds);
        return shownByThree(gltf.scene);
      },
      draw: () => drawn(scene, new THREE.Box3().setFromObject(gltf.scene)),
    };
  },
  usd: async (file) => {
    const root = await new USDLoader().loadAsync(file);
    const scene = new THREE.Scene();
    scene.add(root);
    const clips = root.animations ?? [];
    const mixer = new THREE.AnimationMixer(root);
    return {
      animations: clips.map((each) => each.name),
      pose: (name, seconds) => {
        const clip = clips.find((each) => each.name === name);
        if (clip) {
          const action = mixer.clipAction(clip);
          action.setLoop(THREE.LoopOnce, 1).clampWhenFinished = true;
          action.play();
          mixer.setTime(seconds);
        }
        return shownByThree(root);
      },
      draw: () => drawn(scene, new THREE.Box3().setFromObject(root)),
    };
  },
  babylon: async (file) => {
    const { BABYLON } = window;
    BABYLON.MeshoptCompression.Configuration.decoder.url = "/meshopt_decoder.cjs";
    const canvas = document.createElement("canvas");
    document.body.append(canvas);
    const scene = new BABYLON.Scene(new BABYLON.Engine(canvas, true));
    scene.useRightHandedSystem = true;
    scene.createDefaultCamera(true, true, true);
    await BABYLON.SceneLoader.AppendAsync("/", file.replace(/^\//, ""), scene);
    for (const each of scene.animationGroups) each.stop();
    return {
      animations: scene.animationGroups.map((each) => each.name),
      pose: (name, seconds) => {
        const group = scene.animationGroups.find((each) => each.name === name);
        group.start(false);
        group.goToFrame(seconds * 60); // the loader lays 60 frames in a second
        group.pause();
        scene.render();
        const found = {};
        for (const mesh of scene.meshes) {
          const matrix = mesh.computeWorldMatrix(true);
          const scale = new BABYLON.Vector3();
          matrix.decompose(scale);
          if (!mesh.getTotalVertices() || scale.length() < LEAST) continue;
          const flat = mesh.getPositionData(false, true);
          const points = [];
          for (let k = 0; k < flat.length; k += 3) {
            const at = BABYLON.Vector3.TransformCoordinates(new BABYLON.Vector3(flat[k], flat[k + 1], flat[k + 2]), matrix);
            points.push(at.x, at.y, at.z);
          }
          let named = mesh;
          while (named.parent && !/epoch|threads|hooks|bed/i.test(named.name)) named = named.parent;
          const { albedoColor, albedoTexture, name: material } = mesh.material;
          (found[named.name] ??= []).push({
            points, material, color: albedoColor.asArray(), picture: Boolean(albedoTexture),
          });
        }
        return found;
      },
    };
  },
  "model-viewer": async (file) => {
    const viewer = document.createElement("model-viewer");
    customElements.get("model-viewer").meshoptDecoderLocation = "/meshopt_decoder.cjs";
    Object.assign(viewer, { src: file, loading: "eager", reveal: "auto" });
    viewer.style.cssText = "width:640px;height:360px;display:block";
    const loaded = new Promise((then, fail) => {
      viewer.addEventListener("load", then, { once: true });
      viewer.addEventListener("error", (event) => fail(new Error(JSON.stringify(event.detail))), { once: true });
    });
    document.body.append(viewer);
    await loaded;
    const own = Object.getOwnPropertySymbols(viewer).find((each) => each.description === "scene");
    return {
      animations: viewer.availableAnimations,
      pose: async (name, seconds) => {
        viewer.animationName = name;
        await viewer.updateComplete;
        viewer.pause();
        viewer.currentTime = seconds;
        await new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)));
        const { model } = viewer[own];
        return shownByThree(model);
      },
    };
  },
};

let opened;
window.players = {
  open: async (player, file) => {
    opened = await players[player](file);
    return opened.animations;
  },
  pose: (name, seconds) => opened.pose(name, seconds),
  draw: () => opened.draw(),
};
