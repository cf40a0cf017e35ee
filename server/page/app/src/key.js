// The form that asks for a key where the server wants one.

import {useKey} from "./api.js";
import {byId} from "./dom.js";

/** Calls then() once the user has given a key. */
export function askForKey(then) {
  byId("key-form").hidden = false;
  byId("key").focus();
  byId("key-form").onsubmit = (event) => {
    event.preventDefault();
    useKey(byId("key").value.trim());
    byId("key").value = "";
    byId("key-form").hidden = true;
    then();
  };
}
