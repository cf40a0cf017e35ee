// Loads the page at / after its first paint: parsing three.js takes a tenth of a second and more.

const here = document.currentScript.src;
requestAnimationFrame(() => setTimeout(() => import(new URL("./page.js", here).href)));
