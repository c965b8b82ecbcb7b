// A button beside each block of text copies it; where that is not allowed, the text is selected.
const { copy, copied, selected } = document.currentScript.dataset;
for (const text of document.querySelectorAll("pre")) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "copy";
  button.textContent = copy;
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(text.textContent);
      button.textContent = copied;
    } catch {
      for (let fold = text.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
      getSelection().selectAllChildren(text);
      button.textContent = document.execCommand("copy") ? copied : selected;
    }
  });
  (text.closest("details") ?? text).before(button);
}
