// The buttons and sliders beside the points.

const byId = (id) => document.getElementById(id);

/** Connect the controls with a viewer, and return what brings them up to date. */
function connect(viewer) {
  const { scene, slab } = viewer;
  const onClick = (id, action) => byId(id).addEventListener("click", action);
  const onInput = (id, action) => byId(id).addEventListener("input", (event) => action(event.target));

  byId("clouds").hidden = scene.clouds.length < 2;
  byId("blend-row").hidden = !scene.is_paired;
  onClick("before", () => viewer.show("one", 0));
  onClick("after", () => viewer.show("one", 1));
  onClick("side", () => viewer.show("side"));
  onClick("overlay", () => viewer.show("overlay"));
  onInput("blend", (input) => viewer.show("one", Number(input.value) / 100));

  const menu = byId("column");
  if (scene.dimension === 3) menu.add(new Option("shading only", "-1"));
  scene.columns.forEach((column, k) => menu.add(new Option(column.label, String(k))));
  menu.addEventListener("change", () => viewer.color(Number(menu.value)));

  onClick("reset", () => viewer.look(scene.view));
  for (const name of Object.keys(VIEWS)) onClick(name, () => viewer.look(VIEWS[name]));
  onInput("size", (input) => viewer.resize(2 ** Number(input.value)));
  const isFlat = scene.dimension === 2;
  for (const id of ["top", "front", "right"]) byId(id).hidden = isFlat;

  const across = byId("slab");
  if (isFlat) {
    for (const option of [...across.options]) {
      if (["z", "view"].includes(option.value)) option.remove();
    }
  }
  across.addEventListener("change", () => viewer.slice(across.value));
  onInput("slab-position", (input) => viewer.setSlab({ position: Number(input.value) }));
  onInput("slab-thickness", (input) => viewer.setSlab({ thickness: Number(input.value) }));
  onClick("profile", () => viewer.profile());
  onClick("measure", () => viewer.measure(!viewer.isMeasuring));

  return () => {
    const { mode, share } = viewer;
    const pressed = { before: mode === "one" && share === 0, after: mode === "one" && share === 1,
      side: mode === "side", overlay: mode === "overlay", measure: viewer.isMeasuring };
    for (const [id, is] of Object.entries(pressed)) byId(id).setAttribute("aria-pressed", String(is));
    byId("blend").value = String(mode === "one" ? Math.round(100 * share) : 100);
    menu.value = String(viewer.columnNumber);
    byId("slab-rows").hidden = !slab.isOn;
    if (slab.isOn) [byId("slab-place").value, byId("slab-width").value] = slab.words;
    byId("points").classList.toggle("picking", viewer.isMeasuring);
    byId("readout").textContent = viewer.words;
  };
}
