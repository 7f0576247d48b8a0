// What the table's page needs to check a session, and fetches for the first check.

export { readExport } from "./export.js";
export { report } from "./report.js";
export { openTools } from "./tools.js";
