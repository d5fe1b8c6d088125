"""Tests of @NAME@.py: python3 -m unittest test_@NAME@"""

import unittest

from @NAME@ import measure
from @NAME@_port import Reading, reading_of, words_of


class Measuring(unittest.TestCase):
    def test_a_reading_comes_back_from_its_words(self) -> None:
        reading = measure(None)
        self.assertIsInstance(reading, Reading)
        self.assertEqual(reading_of(words_of(reading)), reading)


if __name__ == "__main__":
    unittest.main()
