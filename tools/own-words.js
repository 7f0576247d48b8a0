// An ESLint rule: what people read stands in static/js/texts, not in the modules of the pages.

/** Two words, or one that begins like a sentence: no name of an event, a class or a field looks so. */
const READ = /\p{L}{2,},? \p{L}{2,}|^\s*\p{Lu}\p{Ll}+[.…!?]?$/u;
const CODE = /[[\]<>]/; // of a selector or of HTML

/** What takes strings that are no text: selectors, keys of the keyboard, bytes that are signed. */
const TAKERS = new Set(["querySelector", "querySelectorAll", "closest", "matches", "isWithin", "matchMedia",
  "bytesOfText", "statement", "stated", "set", "get", "startsWith", "endsWith", "includes"]);
/** What holds strings that are no text: looks, and what boards call things in every language. */
const PROPERTIES = new Set(["class", "font", "style", "kind", "name", "gravity", "material"]);

/** @param {any} node @returns {string} the name of what is called, set or made there */
function nameOf(node) {
  return node?.property?.name ?? node?.name ?? node?.value ?? "";
}

/**
 * @param {any} node a string within an expression
 * @returns {boolean} whether it is no text for people where it stands
 */
function isNoText(node) {
  const { parent } = node;
  switch (parent?.type) {
    case "TemplateLiteral": case "ConditionalExpression": case "LogicalExpression": case "ArrayExpression":
      return isNoText(parent);
    case "BinaryExpression": return parent.operator !== "+" || isNoText(parent);
    case "SwitchCase": case "ImportDeclaration": case "ExportNamedDeclaration": return true;
    case "NewExpression": return /Error$/.test(nameOf(parent.callee)); // for who reads the console
    case "CallExpression": return TAKERS.has(nameOf(parent.callee));
    case "Property": return parent.key === node || PROPERTIES.has(nameOf(parent.key));
    case "AssignmentExpression": return PROPERTIES.has(nameOf(parent.left));
    case "VariableDeclarator": return /FONT|FAMILY/.test(nameOf(parent.id));
    default: return false;
  }
}

/** @type {import("eslint").Rule.RuleModule} */
export const ownWords = {
  meta: { type: "problem", messages: { own: "“{{text}}” is for people to read: give it a key in static/js/texts." } },
  create(context) {
    /** @param {any} node @param {string} text */
    const look = (node, text) => {
      if (READ.test(text) && !CODE.test(text) && !isNoText(node)) context.report({ node, messageId: "own", data: { text } });
    };
    return {
      Literal: (node) => typeof node.value === "string" && look(node, node.value),
      TemplateElement: (node) => look(node, node.value.raw),
    };
  },
};
