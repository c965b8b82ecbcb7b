// Elements: text is always set as text, so that no name of a file or channel is read as markup.

import { spoken } from "./naming.js";

export const byId = (id) => document.getElementById(id);

export function el(tag, props = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key === "test") node.dataset.testid = value;
    else if (key in node && typeof value !== "string") node[key] = value;
    else node.setAttribute(key, value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

export const button = (text, test, onclick, props = {}) => el("button", { type: "button", test, onclick, ...props }, text);

export function fill(place, ...children) {
  place.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return place;
}

export function show(place, visible) {
  place.hidden = !visible;
}

/** What went wrong, where it was asked for. */
export const complaint = (error, test) => el("p", { class: "error", role: "alert", test }, spoken(error.message));

const asRow = (row) => (typeof row === "string" ? { name: row, title: row } : row);

/** Options of a menu: rows {name, title} of a table of the server, or plain names. */
export function menu(rows, chosen, empty) {
  const items = rows.map(asRow).map((row) => {
    const name = row.code ?? row.name ?? row.symbol;
    return el("option", { value: name, selected: name === chosen }, row.title && row.title !== name ? `${name} - ${row.title}` : name);
  });
  return empty === undefined ? items : [el("option", { value: "" }, empty), ...items];
}

/** Sheets made and escaped by the server; colors of terms are set here, since the policy of the page allows no style in text. */
export function fragment(place, html) {
  place.innerHTML = html;
  for (const node of place.querySelectorAll("[data-color]")) {
    const own = node.dataset.color;
    node.style.color = `var(--${own.slice(1).toLowerCase()}, ${own})`;
  }
  for (const wide of place.querySelectorAll(".scroll")) wide.tabIndex = 0; // scrolled by keys, too
  for (const option of place.querySelectorAll(".option")) option.replaceWith(option.textContent);
  place.normalize();
  const texts = document.createTreeWalker(place, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) texts.currentNode.data = spoken(texts.currentNode.data);
  return place;
}

export const copier = (text, test, label) => button(label, test, (event) => navigator.clipboard.writeText(text).then(() => event.target.classList.add("done")));

export const copyable = (text, test, label) => el("div", { class: "copyable" }, el("pre", { tabIndex: 0, test }, text), copier(text, `${test}-copy`, label));
