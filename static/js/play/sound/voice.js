// One voice of WebAudio: a struck tone that fades by itself.

/** @import { Tone } from "./tones.js" */

/**
 * One struck tone, fading by itself.
 * @param {BaseAudioContext} context
 * @param {AudioNode} into what is played
 * @param {Tone} tone
 * @param {number} later s
 * @param {() => void} onEnd
 */
export function strike(context, into, { frequency, gain, decay, pan, wave, bend }, later, onEnd) {
  const start = context.currentTime + later;
  const voice = context.createOscillator();
  const envelope = context.createGain();
  const place = context.createStereoPanner();
  voice.type = wave;
  voice.frequency.setValueAtTime(bend * frequency, start);
  voice.frequency.exponentialRampToValueAtTime(frequency, start + 0.012);
  envelope.gain.setValueAtTime(0, start);
  envelope.gain.linearRampToValueAtTime(gain, start + 0.002);
  envelope.gain.exponentialRampToValueAtTime(gain / 1000, start + decay);
  place.pan.value = pan;
  voice.connect(envelope).connect(place).connect(into);
  voice.onended = () => {
    place.disconnect();
    onEnd();
  };
  voice.start(start);
  voice.stop(start + decay);
}
