"""Pictures of square markers, made by OpenCV: cards that face the camera, as large as a printed marker looks."""

import cv2
import numpy as np

QUIET = 1.6  # a card's side over its marker's


def picture_of(dictionary, middles, side_px=28.0, shape=(960, 1280), turn=0.3):
    """middles: by number the middle (2,) px of a marker, in OpenCV's pixels or a camera's: (0, 0) is a corner of the
    picture → (height, width, 3) uint8, grey with cards. turn: by which cards are turned in the picture, rad."""
    picture = np.full(shape, 120, np.uint8)
    c, s = np.cos(turn), np.sin(turn)
    around = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) @ [[c, s], [-s, c]]
    for number, middle in middles.items():
        marker = cv2.aruco.generateImageMarker(dictionary, int(number), 240)
        rim = round((QUIET - 1) / 2 * 240)
        card = cv2.copyMakeBorder(marker, rim, rim, rim, rim, cv2.BORDER_CONSTANT, value=255)
        size = len(card)
        corners = np.array([[0, 0], [size, 0], [size, size], [0, size]]) - 0.5
        left, top = np.floor(np.asarray(middle) - QUIET * side_px).astype(int)
        part = picture[max(top, 0) : top + round(2 * QUIET * side_px), max(left, 0) : left + round(2 * QUIET * side_px)]
        there = np.asarray(middle) - 0.5 - (max(left, 0), max(top, 0)) + around * QUIET * side_px / 2
        H = cv2.getPerspectiveTransform(corners.astype(np.float32), there.astype(np.float32))
        shown = cv2.warpPerspective(card, H, part.shape[::-1], flags=cv2.INTER_AREA)
        inside = cv2.warpPerspective(np.full_like(card, 255), H, part.shape[::-1])
        part[inside > 127] = shown[inside > 127]
    return cv2.GaussianBlur(np.repeat(picture[..., None], 3, -1), (3, 3), 0)
