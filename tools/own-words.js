// An ESLint rule: text for people belongs into static/js/texts, not into the modules of the pages.

/** Two words, or one capitalized word: names of events, classes and fields do not match. */
const READ = /\p{L}{2,},? \p{L}{2,}|^\s*\p{Lu}\p{Ll}+[.…!?]?$/u;
const CODE = /[[\]<>]/; // in selectors and HTML

/** Functions whose arguments are not text: selectors, keyboard keys, signed bytes. */
const TAKERS = new Set(["querySelector", "querySelectorAll", "closest", "matches", "isWithin", "matchMedia",
  "bytesOfText", "statement", "stated", "set", "get", "startsWith", "endsWith", "includes"]);
/** Properties whose values are not text: styles, and names that are the same in every language. */
const PROPERTIES = new Set(["class", "font", "style", "kind", "name", "gravity", "material"]);

/** @param {any} node @returns {string} the name of the function, property or variable */
function nameOf(node) {
  return node?.property?.name ?? node?.name ?? node?.value ?? "";
}

/**
 * @param {any} node a string within an expression
 * @returns {boolean} whether its position shows that it is not text for people
 */
function isNoText(node) {
  const { parent } = node;
  switch (parent?.type) {
    case "TemplateLiteral": case "ConditionalExpression": case "LogicalExpression": case "ArrayExpression":
      return isNoText(parent);
    case "BinaryExpression": return parent.operator !== "+" || isNoText(parent);
    case "SwitchCase": case "ImportDeclaration": case "ExportNamedDeclaration": return true;
    case "NewExpression": return /Error$/.test(nameOf(parent.callee)); // for developers, in the console
    case "CallExpression": return TAKERS.has(nameOf(parent.callee));
    case "Property": return parent.key === node || PROPERTIES.has(nameOf(parent.key));
    case "AssignmentExpression": return PROPERTIES.has(nameOf(parent.left));
    case "VariableDeclarator": return /FONT|FAMILY/.test(nameOf(parent.id));
    default: return false;
  }
}

/** @type {import("eslint").Rule.RuleModule} */
export const ownWords = {
  meta: { type: "problem", messages: { own: "“{{text}}” is text for people: move it to static/js/texts and use its key." } },
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
