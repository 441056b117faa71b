// The page, once it is there.

/** Show a message over the picture, or none. */
function tell(text) {
  byId("message").textContent = text;
  byId("message").hidden = !text;
}

async function main() {
  try {
    const viewer = new Viewer(await Scene.read(), byId("points"), byId("labels"));
    await viewer.start();
    tell("");
  } catch (error) {
    tell(error.message);
    throw error;
  }
}

main();
